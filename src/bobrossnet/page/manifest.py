"""The interface of <bob-view> as tools read it: the custom elements manifest, and types for frameworks.

Both come from viewer/component/bob-view.js: its tables of attributes and events, and its commented members.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from bobrossnet.page.joining import COMPONENT

NAME = "bob-view"
CLASS = "BobView"

TABLE = re.compile(r"^ \* \| (attribute|event) \| \|\n \* \|---\|---\|\n((?: \* \|.*\n)+)", re.MULTILINE)
ROW = re.compile(r"^ \* \| (`[\w-]+`(?:, `[\w-]+`)*) \| (.*) \|$", re.MULTILINE)
NAMES = re.compile(r"[\w-]+")
FLAG = re.compile(r'hasAttribute\("([\w-]+)"\)')
MEMBER = re.compile(
    r"^  /\*\*(?P<comment>(?:(?!\*/).)*)\*/\n"
    r"  (?P<static>static )?(?P<kind>get |set |async )?(?P<name>(?!async )[a-z]\w*)(?P<call>\()?",
    re.DOTALL | re.MULTILINE,
)
TAG = re.compile(r"@(param|returns) \{((?:[^{}]|\{[^{}]*\})*)\} ?(\[?[a-z]\w*\]?)?(?: (.*))?")
INTERNAL = ("attributeChangedCallback", "begun")

TYPES = """\
/** <bob-view>: see README.md. */
import {{ BobView as Commented }} from "./component/bob-view.js";

export {{ type Camera }} from "./component/bob-view.js";

/** The attributes of <bob-view>. */
export interface BobViewAttributes {{
{attributes}}}

/** Its properties that reflect attributes. */
export interface BobViewProperties {{
{properties}}}

export type BobView = InstanceType<typeof Commented> & BobViewProperties;
export declare const BobView: {{ new (): BobView }} & typeof Commented;

declare global {{
  interface HTMLElementTagNameMap {{
    "{name}": BobView;
  }}
}}
"""

REACT = f"""\
/** <{NAME}> in JSX: `import type {{}} from "{NAME}/react"`. */
import type {{ ClassAttributes, HTMLAttributes }} from "react";
import type {{ BobView, BobViewAttributes }} from "./index.js";

declare module "react" {{
  namespace JSX {{
    interface IntrinsicElements {{
      "{NAME}": BobViewAttributes & ClassAttributes<BobView> & HTMLAttributes<BobView>;
    }}
  }}
}}
"""

VUE = f"""\
/** <{NAME}> in templates: `import type {{}} from "{NAME}/vue"`. */
import type {{ DefineComponent }} from "vue";
import type {{ BobViewAttributes }} from "./index.js";

declare module "vue" {{
  interface GlobalComponents {{
    "{NAME}": DefineComponent<BobViewAttributes>;
  }}
}}
"""


def manifest(viewer: Path) -> str:
    """Return custom-elements.json, of schema 1.0.0."""
    text = (viewer / COMPONENT).read_text("utf-8")
    element = {
        "kind": "class",
        "customElement": True,
        "tagName": NAME,
        "name": CLASS,
        "description": "Displays a scene, ray traced; while it turns, each picture traces a few percent of its pixels.",
        "superclass": {"name": "HTMLElement"},
        "attributes": [
            {"name": name, "description": description, "type": {"text": _type(text, name)}}
            for name, description in rows(viewer, "attribute")
        ],
        "events": [
            {"name": name, "description": description, "type": {"text": "CustomEvent"}}
            for name, description in rows(viewer, "event")
        ],
        "members": _members(text) + _reflected(viewer),
    }
    where = {"name": CLASS, "module": COMPONENT}
    exports = [
        {"kind": "js", "name": CLASS, "declaration": where},
        {"kind": "custom-element-definition", "name": NAME, "declaration": where},
    ]
    module = {"kind": "javascript-module", "path": COMPONENT, "declarations": [element], "exports": exports}
    return json.dumps({"schemaVersion": "1.0.0", "readme": "README.md", "modules": [module]}, indent=2) + "\n"


def types(viewer: Path) -> dict[str, str]:
    """Return the files of types besides those made by TypeScript from the modules' comments, by name."""
    text = (viewer / COMPONENT).read_text("utf-8")
    attributes = "".join(
        f'  /** {description} */\n  "{name}"?: {_type(text, name)};\n'
        for name, description in rows(viewer, "attribute")
    )
    properties = "".join(f"  {each['name']}: {each['type']['text']};\n" for each in _reflected(viewer))
    index = TYPES.format(name=NAME, attributes=attributes, properties=properties)
    return {"index.d.ts": index, "react.d.ts": REACT, "vue.d.ts": VUE}


def rows(viewer: Path, kind: str) -> list[tuple[str, str]]:
    """Return names and descriptions from the element's table of this kind."""
    text = (viewer / COMPONENT).read_text("utf-8")
    (table,) = [table for found, table in TABLE.findall(text) if found == kind]
    return [(name, description) for names, description in ROW.findall(table) for name in NAMES.findall(names)]


def _reflected(viewer: Path) -> list[dict[str, Any]]:
    """Return the properties that reflect attributes (viewer/component/properties.js), except commented members."""
    text = (viewer / COMPONENT).read_text("utf-8")
    own = {member["name"] for member in _members(text) if not member.get("static")}
    fields = []
    for attribute, description in rows(viewer, "attribute"):
        name = re.sub(r"-(.)", lambda found: found[1].upper(), attribute)
        type_ = "boolean" if _type(text, attribute) == "boolean" else "string | null"
        field = {"kind": "field", "name": name, "description": description, "type": {"text": type_}}
        if name not in own:
            fields.append({**field, "attribute": attribute, "reflects": True})
    return fields


def _type(text: str, attribute: str) -> str:
    return "boolean" if attribute in FLAG.findall(text) else "string"


def _members(text: str) -> list[dict[str, Any]]:
    """Return the public fields and methods that have a comment."""
    members: dict[str, dict[str, Any]] = {}
    for found in MEMBER.finditer(text):
        name, tags = found["name"], TAG.findall(found["comment"])
        if name in members or name in INTERNAL:
            continue
        is_method = found["call"] is not None and found["kind"] not in ("get ", "set ")
        description = re.sub(r"[\s*]+", " ", re.split(r"@(?:param|returns|type)\b", found["comment"])[0]).strip()
        member: dict[str, Any] = {"kind": "method" if is_method else "field", "name": name, "description": description}
        if found["static"]:
            member["static"] = True
        returned = next(({"text": type_} for tag, type_, *_ in tags if tag == "returns"), None)
        if is_method:
            member["parameters"] = [
                {"name": of.strip("[]"), "type": {"text": type_}, **({"optional": True} if of.startswith("[") else {})}
                for tag, type_, of, _ in tags
                if tag == "param"
            ]
        if returned:
            member |= {"return": {"type": returned}} if is_method else {"type": returned}
        members[name] = member
    return list(members.values())
