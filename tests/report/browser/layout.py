"""What is wrong with a page as a picture: it scrolls sideways, texts lie over each other or are cut.

The browser says where things are; what that means is decided here. Each check returns its faults in words.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from typing import Any

from playwright.sync_api import Page

LEADING = 0.15  # of the size of a line: its box is that much larger than its letters, on every side
SLACK = 1.0  # px

# Every text that is seen: boxes of its lines, and the box that ancestors cut it to, hard (hidden) or soft (scrolled).
TEXTS = """root => {
  const everything = [-1e9, -1e9, 1e9, 1e9], frames = new Map();
  const within = (a, b) => [Math.max(a[0], b[0]), Math.max(a[1], b[1]), Math.min(a[2], b[2]), Math.min(a[3], b[3])];
  const box = r => [r.left, r.top, r.right, r.bottom];
  const framed = element => {
    if (!element || element === document.body) return {hard: everything, soft: everything, hidden: false};
    if (frames.has(element)) return frames.get(element);
    let {hard, soft, hidden} = framed(element.parentElement);
    const drawn = element instanceof SVGElement && element.tagName !== 'svg';
    const style = drawn ? null : getComputedStyle(element);
    if (style && style.overflowX !== 'visible' && (style.display !== 'inline' || element.tagName === 'svg')) {
      const own = box(element.getBoundingClientRect());
      if (/auto|scroll/.test(style.overflowX + style.overflowY)) soft = within(soft, own);
      else hard = within(hard, own);
    }
    if (style && (style.clipPath.startsWith('inset(') || (style.clip !== 'auto' && style.position === 'absolute')))
      hidden = true;  // for screen readers alone
    frames.set(element, {hard, soft, hidden});
    return {hard, soft, hidden};
  };
  const found = [], walker = document.createTreeWalker(document.querySelector(root), NodeFilter.SHOW_TEXT);
  const range = document.createRange();
  while (walker.nextNode()) {
    const node = walker.currentNode, owner = node.parentElement;
    if (!node.data.trim() || !owner.checkVisibility({visibilityProperty: true, opacityProperty: true})) continue;
    const {hard, soft, hidden} = framed(owner), drawn = owner instanceof SVGElement;
    if (hidden) continue;
    range.selectNodeContents(node);
    const rects = drawn ? [owner.getBoundingClientRect()]
      : owner.tagName === 'PRE' ? [range.getBoundingClientRect()] : [...range.getClientRects()];
    const lines = rects.filter(r => r.width > 0 && r.height > 0).map(box);
    if (lines.length)
      found.push({text: node.data.trim().slice(0, 60), in: owner.tagName.toLowerCase(), drawn, lines, hard, soft});
  }
  return found;
}"""

# How far the page reaches to the right, and what does it.
SIDEWAYS = """() => {
  const root = document.scrollingElement, wide = root.clientWidth;
  const scrolled = e => { for (e = e.parentElement; e && e !== document.body; e = e.parentElement)
    if (getComputedStyle(e).overflowX !== 'visible') return true; return false; };
  const out = [...document.body.querySelectorAll('*')].filter(
    e => e.getBoundingClientRect().right > wide + 1 && !scrolled(e)).map(
    e => e.tagName.toLowerCase() + (e.className && e.className.baseVal === undefined ? '.' + e.className : ''));
  return {content: root.scrollWidth, wide, out: out.slice(0, 5)};
}"""

Box = tuple[float, float, float, float]
Texts = list[dict[str, Any]]


@dataclass(frozen=True)
class Line:
    """One line of a text, its letters [px]; ``number`` is that of the text."""

    number: int
    text: str
    box: Box


def sideways(page: Page) -> list[str]:
    """Return what makes the page scroll sideways."""
    found: dict[str, Any] = page.evaluate(SIDEWAYS)
    if found["content"] <= found["wide"]:
        return []
    return [f"{found['content']} px of content in {found['wide']} px: {', '.join(found['out'])}"]


def seen_texts(page: Page, root: str = "body") -> Texts:
    """Return every text of a part that is seen, for the checks below; one look serves all of them."""
    found: Texts = page.evaluate(TEXTS, root)
    return found


def cut_texts(texts: Texts, paper: bool = False) -> list[str]:
    """Return the texts that are not to be seen whole; on paper what can be scrolled to is lost as well."""
    faults = []
    for one in texts:
        frame = _common(one["hard"], one["soft"]) if paper else one["hard"]
        outside = [line for line in one["lines"] if not _is_inside(_letters(line), frame)]
        if outside:
            faults.append(f"<{one['in']}> cut: {one['text']!r}")
    return faults


def overlapping_texts(texts: Texts) -> list[str]:
    """Return the pairs of texts that lie over each other, in figures, tables and everywhere else."""
    lines = [
        Line(number, f"<{one['in']}> {one['text']!r}", seen)
        for number, one in enumerate(texts)
        for line in one["lines"]
        if (seen := _common(_letters(line), _common(one["hard"], one["soft"])))
        and seen[2] - seen[0] > SLACK
        and seen[3] - seen[1] > SLACK
    ]
    return [f"{a.text} over {b.text}" for a, b in islice(_overlaps(lines), 10)]


def _overlaps(lines: list[Line]) -> Iterator[tuple[Line, Line]]:
    """Go down the page: each line is held against those that have not ended above it."""
    open_lines: list[Line] = []
    for line in sorted(lines, key=lambda one: one.box[1]):
        open_lines = [one for one in open_lines if one.box[3] > line.box[1] + SLACK]
        for one in open_lines:
            common = _common(one.box, line.box)
            if one.number != line.number and common[2] - common[0] > SLACK and common[3] - common[1] > SLACK:
                yield one, line
        open_lines.append(line)


def _letters(line: list[float]) -> Box:
    left, top, right, bottom = line
    edge = LEADING * min(right - left, bottom - top)
    return left + edge, top + edge, right - edge, bottom - edge


def _common(a: Any, b: Any) -> Box:
    return max(a[0], b[0]), max(a[1], b[1]), min(a[2], b[2]), min(a[3], b[3])


def _is_inside(box: Box, frame: Any) -> bool:
    left, top, right, bottom = box
    over = (frame[0] - left, frame[1] - top, right - frame[2], bottom - frame[3])
    return max(map(float, over)) <= SLACK
