"""What a page does with texts that it was given: whether one ran, loaded, said something, or changed its elements."""

from __future__ import annotations

import re
import unicodedata
from typing import Any

from browsing import Visit
from injections import EVALUATED
from playwright.sync_api import Page

# Open, focus, point at and press everything, so that what waits for it would run.
WAKE = """() => {
  document.querySelectorAll('details').forEach(one => { one.open = true; });
  for (const one of document.querySelectorAll('body, body *')) {
    for (const kind of ['mouseover', 'pointerenter', 'focus', 'copy', 'wheel'])
      one.dispatchEvent(new Event(kind, {bubbles: false}));
    if (one.matches('button.copy')) one.click();
  }
}"""

# Attributes that run or load: the page has none but links inside itself and data in its own text.
ACTIVE = r"""() => [...document.querySelectorAll('*')].flatMap(e => [...e.attributes].filter(a =>
  a.name.startsWith('on') || ['srcdoc', 'ping', 'background', 'formaction', 'srcset', 'action'].includes(a.name)
  || (['href', 'src', 'xlink:href', 'data', 'poster'].includes(a.name) && !/^#|^data:text\/csv[;,]/.test(a.value))
  || /url\((?!["']?#)|expression|@import/i.test(a.name === 'style' ? a.value : '')
).map(a => `<${e.tagName.toLowerCase()} ${a.name}=${a.value.slice(0, 80)}>`))"""

ELEMENTS = """() => [...document.querySelectorAll('*')].map(
  e => e.tagName + ' ' + [...e.attributes].map(a => a.name).sort().join(' '))"""

# Texts whose direction marks could turn what stands around them: not alone in a block, and not isolated.
LEAKS = r"""() => {
  const found = [], walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const node = walker.currentNode;
    if (!/[\u202a-\u202e\u2066-\u2069]/.test(node.data) || node.parentElement instanceof SVGElement) continue;
    let e = node.parentElement, isolated = false;
    if (!e.checkVisibility()) continue;
    while (getComputedStyle(e).display === 'inline' && !isolated) {
      isolated = /isolate|plaintext/.test(getComputedStyle(e).unicodeBidi);
      e = e.parentElement;
    }
    if (!isolated && e.textContent.trim() !== node.data.trim()) found.push(node.data.slice(0, 60));
  }
  return found;
}"""

REPLACED = "\N{REPLACEMENT CHARACTER}"


def reactions(seen: Visit) -> list[str]:
    """Return what ran, was loaded, or was said, after everything on the page was pointed at and pressed."""
    page = seen.page
    page.evaluate(WAKE)
    page.wait_for_timeout(50)
    faults = [f"asked for {address}" for address in seen.loaded] + seen.happened
    faults += [f"active: {one}" for one in page.evaluate(ACTIVE)]
    if page.evaluate("window.__pwned"):
        faults.append("a text ran as a script")
    if EVALUATED in page.evaluate("document.body.innerText"):
        faults.append("a text ran as a template")
    return faults


def elements(page: Page) -> list[str]:
    """Return every element with the names of its attributes, in order."""
    found: list[str] = page.evaluate(ELEMENTS)
    return found


def bidi_leaks(page: Page) -> list[str]:
    """Return the texts that can turn the direction of what stands around them."""
    return [f"turns what is around it: {one!r}" for one in page.evaluate(LEAKS)]


def letters(text: str) -> str:
    """Return a text without blanks and marks that are not seen, which a page may show in its own way."""
    seen: Any = (c for c in text if c.isprintable() and unicodedata.category(c)[0] not in "CZM" and c != REPLACED)
    return re.sub(r"\s+", "", "".join(seen))
