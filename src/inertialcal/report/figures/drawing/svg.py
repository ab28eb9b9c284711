"""A picture as SVG inside a page: colours by CSS variables, ids of its own, the same bytes every time.

What stands in it: shapes, and texts as texts in the page's font. What does not: a prolog, a date, the name of a
program, a style sheet (it would hold for the whole page), a script, a reference to anything outside the figure; nor a
title, which browsers would show over the values of its marks.
"""

from __future__ import annotations

import io
import re
import warnings
from collections.abc import Mapping
from xml.etree import ElementTree as ET

from matplotlib import rc_context
from matplotlib.backends.backend_svg import FigureCanvasSVG

from .picture import Picture, on_new_figure
from .style import COLOURS
from .values import ABOVE, Values, values

SALT = "inertialcal"
FONT = "var(--fig-font, 'DejaVu Sans', Verdana, 'Segoe UI', sans-serif)"
XLINK = "{http://www.w3.org/1999/xlink}href"
NAMESPACE = "http://www.w3.org/2000/svg"
INK = f"fill: var(--fig-ink, {COLOURS['ink']})"
SIZE = "font-size: 9px"  # of most texts
WHOLE = f"stroke-linejoin: round; stroke-linecap: butt; display: block; width: 100%; height: auto; {SIZE}; {INK}"
DEFAULT = {SIZE, INK, "text-anchor: start"}  # of texts
UNSEEN = "fill: none"
GEOMETRY = ("d", "x", "y", "width", "height", "transform", "points", "cx", "cy", "r")
_HREF = re.compile(r"url\(#([^)]+)\)")
_COLOUR = re.compile("|".join(re.escape(light) for light in COLOURS.values()), re.IGNORECASE)
_ROLE = {light: role for role, light in COLOURS.items()}
_LONG = re.compile(r"-?\d+\.\d{2,}")
_FAMILY = re.compile(r"; font-family:[^;]*|(?<=font): (?=[\d.]+px)([\d.]+px) '[^;]*")
_STEP = re.compile(r"([MLQCZz])([^MLQCZz]*)")
_NUMBER = re.compile(r"-?\d*\.?\d+(?:e[+-]?\d+)?")
_STROKE = re.compile(r"M0 0[hv][^a-z]+")  # a mark of one stroke, as those of ticks
MANY = 8  # marks of one kind, from which they are the corners of one path


def to_svg(picture: Picture, prefix: str, with_values: bool = False) -> str:
    """Return a picture as an ``<svg>`` element.

    Parameters
    ----------
    picture : Picture
        What to draw.
    prefix : str
        Of its ids.
    with_values : bool
        Whether its marks show what they stand for, on a page whose style sheet hides it until then.
    """
    drawn, found = _saved(picture)
    root = ET.fromstring(drawn)  # noqa: S314 - written by matplotlib a line ago
    _strip(root)
    _gather_styles(root)
    _gather_marks(root)
    _rename(root, re.sub(r"[^A-Za-z0-9]+", "-", prefix))
    _unwrap(root)
    if with_values and found is not None:
        root.append(_shown(found))
    root.attrib = {
        "xmlns": NAMESPACE, "viewBox": root.attrib["viewBox"], "role": "img", "aria-label": picture.label,
        "class": "figure", "style": f"{WHOLE}; font-family: {FONT}",
    }  # fmt: skip
    return ET.tostring(root, encoding="unicode").replace(" />", "/>")


def _saved(picture: Picture) -> tuple[bytes, Values | None]:
    out = io.BytesIO()
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": SALT}), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing")  # the reader's fonts have it, or not
        figure = on_new_figure(picture, titled=False)
        figure.set_facecolor("none")
        nothing = dict.fromkeys(("Date", "Creator", "Format", "Type"))
        FigureCanvasSVG(figure).print_svg(out, metadata=nothing)  # type: ignore[no-untyped-call]
    return out.getvalue(), values(figure)


def _shown(found: Values) -> ET.Element:
    """Return a group of places, each with the text that is seen when the pointer is there; all end at one place."""
    whole = ET.Element("g", {"class": "v", "transform": f"translate({found.end:.0f} {ABOVE:.0f})"})
    for point in found.points:
        group = ET.SubElement(whole, "g")
        places = ((round(10.0 * (x - round(found.end))), round(10.0 * (y - ABOVE))) for x, y in point.places)
        ET.SubElement(group, "path", {"d": "".join(f"M{_pair(x, y)}h0" for x, y in places)})
        ET.SubElement(group, "text").text = point.text
    return whole


def _strip(root: ET.Element) -> None:
    """Take away namespaces, metadata and style sheets; shorten numbers; name colours by their role."""
    for parent in list(root.iter()):
        for child in list(parent):
            if child.tag.rpartition("}")[2] in {"metadata", "style"} or child.attrib.get("style") == UNSEEN:
                parent.remove(child)
    for element in root.iter():
        element.tag = element.tag.rpartition("}")[2]
        if XLINK in element.attrib:
            element.attrib["href"] = element.attrib.pop(XLINK)
        for name, value in element.attrib.items():
            element.attrib[name] = _attribute(name, value)
        if element.attrib.get("transform", "").startswith("rotate(-0 "):
            del element.attrib["transform"]
        if element.tag == "text":
            said = [one for one in element.attrib.get("style", "").split("; ") if one not in DEFAULT]
            element.attrib["style"] = "; ".join(said)
            if not said:
                del element.attrib["style"]
        else:
            element.text = None
        element.tail = None


def _attribute(name: str, value: str) -> str:
    if name == "d":
        return _short_path(value)
    if name in GEOMETRY:
        return _LONG.sub(lambda found: _short(round(10.0 * float(found[0]))), value).replace("\n", " ")
    if name in {"style", "fill", "stroke"}:
        named = _COLOUR.sub(lambda found: f"var(--fig-{_ROLE[found[0].lower()]}, {found[0].lower()})", value)
        return _FAMILY.sub(lambda found: f"-size: {found[1]}" if found[1] else "", named)
    return value


def _short(tenths: int) -> str:
    """Return tenths of a point as few letters: ``.5``, ``-12``."""
    whole, rest = divmod(abs(tenths), 10)
    digits = f"{whole or ''}.{rest}" if rest else f"{whole}"
    return f"-{digits}" if tenths < 0 else digits


def _pair(x: int, y: int) -> str:
    """Return a place in tenths of a point: ``3.5-2``; nothing stands between where it is clear without."""
    first, second = _short(x), _short(y)
    apart = second[0] == "-" or (second[0] == "." and "." in first)
    return f"{first}{'' if apart else ' '}{second}"


def _short_path(value: str) -> str:
    """Return a path in steps from point to point, in tenths of a point; a place is never off by more than half."""
    x = y = start_x = start_y = 0
    said: list[str] = []
    for command, rest in _STEP.findall(value):
        if command in "Zz":
            said.append("z")
            x, y = start_x, start_y
            continue
        places = [round(10.0 * float(one)) for one in _NUMBER.findall(rest)]
        steps = [one - (y if i % 2 else x) for i, one in enumerate(places)]
        if command == "L" and 0 in steps:
            said.append(f"h{_short(steps[0])}" if steps[1] == 0 else f"v{_short(steps[1])}")
        else:
            said.append(command.lower() if said else command)
            said.append(" ".join(_pair(*both) for both in zip(steps[::2], steps[1::2], strict=True)))
        x, y = places[-2:]
        if command == "M":
            start_x, start_y = x, y
    return "".join(said)


def _gather_styles(root: ET.Element) -> None:
    """Give a style that all members of a group have to the group: hundreds of markers are then short."""
    for group in root.iter("g"):
        styles = {child.attrib.get("style") for child in group}
        if len(group) > 1 and len(styles) == 1 and "style" not in group.attrib and (style := styles.pop()):
            group.attrib["style"] = style
            for child in group:
                del child.attrib["style"]


def _unwrap(parent: ET.Element) -> None:
    """Put the members of groups that say nothing in their place."""
    for child in list(parent):
        _unwrap(child)
        if child.tag in {"g", "defs"} and not child.attrib and (child.tag == "g" or not len(child)):
            at = list(parent).index(child)
            parent[at : at + 1] = list(child)


def _gather_marks(root: ET.Element) -> None:
    """Let many marks of one kind be the corners of one path, ticks its pieces: that takes a sixth of the room."""
    shapes = {one.attrib["id"]: one for group in root.iter("defs") for one in group if "id" in one.attrib}
    for number, group in enumerate(list(root.iter("g"))):
        which = {child.attrib.get("href", "") if child.tag == "use" else "" for child in group}
        shape = shapes.get(min(which, default="")[1:])
        if len(which) != 1 or shape is None or any("style" in child.attrib for child in group):
            continue
        stroke = _STROKE.fullmatch(shape.attrib["d"])
        if not stroke and len(group) < MANY:
            continue
        style = _joined(group.attrib.pop("style", ""), shape.attrib.get("style", ""))
        if stroke:
            pieces = "".join(f"M{child.attrib['x']} {child.attrib['y']}{stroke[0][4:]}" for child in group)
            for child in list(group):
                group.remove(child)
            ET.SubElement(group, "path", {"d": pieces, "style": style})
            continue
        name = f"{shape.attrib['id']}-{number}"
        marker = ET.Element("marker", {"id": name, "overflow": "visible", "markerUnits": "userSpaceOnUse"})
        ET.SubElement(marker, "path", {"d": shape.attrib["d"], "style": style})
        places = " L ".join(f"{child.attrib['x']} {child.attrib['y']}" for child in group)
        for child in list(group):
            group.remove(child)
        ends = {f"marker-{end}": f"url(#{name})" for end in ("start", "mid", "end")}
        group.append(marker)
        ET.SubElement(group, "path", {"d": _short_path(f"M {places}"), "fill": "none", **ends})
    _drop_unused(root, shapes)


def _joined(*styles: str) -> str:
    """Return styles as one; of two declarations of one property the last holds."""
    said = [one.split(": ", 1) for style in styles for one in style.split("; ") if one]
    return "; ".join(f"{name}: {value}" for name, value in dict(said).items())


def _drop_unused(root: ET.Element, shapes: Mapping[str, ET.Element]) -> None:
    """Take away the shapes of marks that nothing draws any more."""
    drawn = {one.attrib.get("href", "")[1:] for one in root.iter("use")}
    for defs in root.iter("defs"):
        for name, shape in shapes.items():
            if name not in drawn and shape in list(defs) and shape.tag == "path":
                defs.remove(shape)


def _rename(root: ET.Element, prefix: str) -> None:
    """Count the ids that something refers to, in order of appearance, behind a prefix; take the others away."""
    used: set[str] = set()
    for element in root.iter():
        used |= {found for value in element.attrib.values() for found in _HREF.findall(value)}
        used |= {value[1:] for name, value in element.attrib.items() if name == "href" and value[:1] == "#"}
    own = [element.attrib["id"] for element in root.iter() if element.attrib.get("id") in used]
    new = {old: f"{prefix}-{number}" for number, old in enumerate(dict.fromkeys(own))}
    for element in root.iter():
        old = element.attrib.pop("id", "")
        if old in new:
            element.attrib["id"] = new[old]
        for name, value in element.attrib.items():
            if name == "href" and value[1:] in new:
                element.attrib[name] = "#" + new[value[1:]]
            elif "url(#" in value:
                element.attrib[name] = _HREF.sub(lambda found: f"url(#{new[found[1]]})", value)
