"""Serious faults of accessibility, by axe-core, with everything that is folded opened. The page is pruned for it."""

from __future__ import annotations

from axe_playwright_python.sync_playwright import Axe  # type: ignore[import-untyped]
from playwright.sync_api import Page

SERIOUS = ("serious", "critical")
# Of the data behind the figures, which are alike and long, one is opened.
UNFOLD = """() => document.querySelectorAll('details').forEach(one => {
  one.open = !one.matches('.data') || one === document.querySelector('details.data'); })"""

# Of neighbours that are made of the same kinds of elements two stay, and axe does not look into drawings: more of the
# same only takes time.
PRUNE = """() => {
  document.querySelectorAll('svg :not(title)').forEach(one => one.remove());
  document.querySelectorAll('pre').forEach(one => { one.textContent = one.textContent.slice(0, 200); });
  const kind = e => e.tagName + '.' + e.className;
  const made = e => [kind(e), ...new Set([...e.querySelectorAll('*')].map(kind))].join(' ');
  for (const tag of ['tr', 'li', 'figure', 'details', '.scroll', 'section.test']) {
    const seen = new Map();
    for (const one of document.querySelectorAll(`main ${tag}`)) {
      const counts = seen.get(one.parentElement) || {}, key = made(one);
      seen.set(one.parentElement, counts);
      counts[key] = (counts[key] || 0) + 1;
      if (counts[key] > 2) one.remove();
    }
  }
}"""


def serious_faults(page: Page) -> list[str]:
    """Return rule, number of places and the first of them, for each rule that is broken seriously."""
    page.evaluate(PRUNE)
    page.evaluate(UNFOLD)
    found = Axe().run(page, options={"resultTypes": ["violations"]}).response["violations"]
    return [
        f"{one['id']} ({one['impact']}): {len(one['nodes'])} times: {one['nodes'][0]['html'][:200]}"
        f" {one['nodes'][0].get('failureSummary', '')}"
        for one in found
        if one["impact"] in SERIOUS
    ]
