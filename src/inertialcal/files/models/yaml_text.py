"""YAML of calibration files: maps, lists, numbers and words, and nothing that such a file does not need."""

from __future__ import annotations

import re
from typing import Any

from ...core.errors import DataError
from ..budget import YAML, check_count

DEEPEST = 12  # maps and lists within each other


def parse_yaml(text: str, where: str = "") -> object:
    """Return the content of a YAML file: dicts, lists, numbers, words, None.

    Raises
    ------
    DataError
        ``not_yaml``, with the line, for what is no YAML, and for anchors, aliases, tags, a key twice, or more than 12
        levels: a calibration file needs none of them.
    """
    import yaml  # noqa: PLC0415 - starts slowly

    check_count(len(text), YAML, "characters of YAML", where)

    depth = 0
    try:
        for event in yaml.parse(text, Loader=yaml.SafeLoader):
            if getattr(event, "anchor", None) or getattr(event, "tag", None):
                raise _not_yaml("YAML anchors, aliases and tags are not supported", event.start_mark, where)
            depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
            if depth > DEEPEST:
                raise _not_yaml(f"more than {DEEPEST} nested maps or lists", event.start_mark, where)
        document = yaml.compose(text, Loader=yaml.SafeLoader)
        _check_node(document, where)
        return yaml.constructor.SafeConstructor().construct_document(document)
    except yaml.MarkedYAMLError as error:
        raise _not_yaml(f"not YAML: {error.problem}", error.problem_mark, where) from None
    except (yaml.YAMLError, ValueError) as error:  # a character that YAML has not; a date that there is not
        raise DataError(f"not YAML: {error}".splitlines()[0], where=where, code="not_yaml") from None


def _check_node(node: Any, where: str) -> None:
    """Refuse a key that appears twice; take 1e-5 as the number that it is for everyone but YAML 1.1."""
    if node.id == "scalar":
        if node.style is None and re.fullmatch(r"[-+]?[0-9]+[eE][-+]?[0-9]+", node.value):
            node.tag = "tag:yaml.org,2002:float"
        return
    keys = [key.value for key, _ in node.value] if node.id == "mapping" else []
    for i, value in enumerate(node.value):
        if keys and keys.index(keys[i]) < i:
            raise _not_yaml(f"key {keys[i]!r} appears twice", value[0].start_mark, where)
        _check_node(value[1] if keys else value, where)


def _not_yaml(what: str, mark: Any, where: str) -> DataError:
    place = f"{where}:{mark.line + 1}" if where else f"line {mark.line + 1}"
    return DataError(what, where=place, do="Write it as maps, lists and numbers", code="not_yaml")
