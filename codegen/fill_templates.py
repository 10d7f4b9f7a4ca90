# SPDX-License-Identifier: Apache-2.0
"""Views -> text, by the templates."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from hypgen.codegen.cpp import template_data
from hypgen.codegen.ros2.package_data import Packages

_TEMPLATES = Path(__file__).parent / "templates"
_COLUMNS = 100  # of prose


def render(
    header: template_data.Header,
    main: template_data.Main,
    project: template_data.Project,
    library: template_data.Library,
) -> dict[str, str]:
    """Return the files of a project, which builds a solver and libraries, keyed by their paths."""
    templates = {
        **_library_templates(header, project.stem),
        "src/main.cpp": "main.cpp.j2",
        "CMakeLists.txt": "CMakeLists.txt.j2",
        "README.md": "README.md.j2",
    }
    return _render(templates, header, main, project, library)


def render_exact(
    header: template_data.Header, main: template_data.Main, project: template_data.Project
) -> dict[str, str]:
    """Return the files of the exact solver's program, keyed by their paths."""
    templates = {f"src/{project.stem}.hpp": "model.hpp.j2", "src/exact.cpp": "exact.cpp.j2"}
    return _render(templates, header, main, project)


def render_verify(
    header: template_data.Header, main: template_data.Main, project: template_data.Project
) -> dict[str, str]:
    """Return the files of the program that checks the model's code, keyed by their paths."""
    templates = {
        f"src/{project.stem}.hpp": "model.hpp.j2",
        "src/verify.cpp": "verify.cpp.j2",
        "src/device.cu": "device.cu.j2",
        "src/device_digests.cu": "device_digests.cu.j2",
        **_lanes_template(header),
    }
    return _render(templates, header, main, project)


def render_library(
    header: template_data.Header,
    main: template_data.Main,
    project: template_data.Project,
    library: template_data.Library,
) -> dict[str, str]:
    """Return the files of a project that are of its libraries, with a page for their users."""
    templates = {**_library_templates(header, project.stem), "README.md": "library_README.md.j2"}
    return _render(templates, header, main, project, library)


def _library_templates(header: template_data.Header, stem: str) -> dict[str, str]:
    return {
        **_lanes_template(header),
        f"src/{stem}.hpp": "model.hpp.j2",
        "src/library.cpp": "library.cpp.j2",
        "src/shared.cpp": "shared.cpp.j2",
        "src/device.cu": "device.cu.j2",
        f"include/{stem}.h": "library.h.j2",
        f"cmake/{stem}-config.cmake.in": "config.cmake.j2",
    }


def _lanes_template(header: template_data.Header) -> dict[str, str]:
    return {"src/lanes.cpp": "lanes.cpp.j2"} if header.lanes else {}


def render_ros2(project: template_data.Project, ros: Packages) -> dict[str, str]:
    """Return the files of a model's ROS 2 packages but the planner's solver, keyed by their paths."""
    messages, planner = f"{ros.stem}_msgs", f"{ros.stem}_planner"
    templates = {
        f"{messages}/{name}": f"ros2/msgs/{name}.j2"
        for name in (
            "CMakeLists.txt",
            "package.xml",
            "msg/Decision.msg",
            "msg/Observation.msg",
            "msg/Status.msg",
            "action/Plan.action",
            "srv/Belief.srv",
            "srv/Reset.srv",
        )
    }
    templates |= {
        f"{planner}/{name}": f"ros2/planner/{name}.j2"
        for name in (
            "CMakeLists.txt",
            "README.md",
            "config/planner.yaml",
            "package.xml",
            "src/call_queue.hpp",
            "src/main.cpp",
            "src/message_values.hpp",
            "src/parameter_text.hpp",
            "src/parameters.cpp",
            "src/parameters.hpp",
            "src/planner.cpp",
            "src/planner.hpp",
            "src/planner_node.cpp",
            "src/planner_node.hpp",
        )
    }
    templates[f"{planner}/launch/{planner}.launch.py"] = "ros2/planner/launch/planner.launch.py.j2"
    files = _fill(templates, {"project": project, "ros": ros})
    for kind, found in (("enum", ros.enums), ("record", ros.records)):
        for message in found:
            path = f"{messages}/msg/{message.name}.msg"
            values = {"project": project, "message": message}
            files |= _fill({path: f"ros2/msgs/msg/{kind}.msg.j2"}, values)
    return files


def _render(
    templates: Mapping[str, str],
    header: template_data.Header,
    main: template_data.Main,
    project: template_data.Project,
    library: template_data.Library | None = None,
) -> dict[str, str]:
    values = {"model": header, "main": main, "project": project, "library": library}
    return _fill(templates, values)


def _fill(templates: Mapping[str, str], values: Mapping[str, object]) -> dict[str, str]:
    environment = Environment(
        loader=FileSystemLoader(_TEMPLATES),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,
    )
    environment.filters["function_text"] = _function_text
    files = {path: environment.get_template(name).render(values) for path, name in templates.items()}
    return {path: _wrapped(text) if path.endswith(".md") else text for path, text in files.items()}


def _wrapped(page: str) -> str:
    """Return a page of Markdown with its paragraphs and items laid out anew, as names have any length."""
    parts = re.split(r"(^```.*?^```\n+|\n{2,}|\n(?=- )|\n+\Z)", page, flags=re.DOTALL | re.MULTILINE)
    return "".join(part if part.startswith(("\n", "```", "|", "#")) else _filled(part) for part in parts)


def _filled(paragraph: str) -> str:
    return textwrap.fill(
        " ".join(paragraph.split()),
        _COLUMNS,
        subsequent_indent="  " if paragraph.startswith("- ") else "",
        break_long_words=False,
        break_on_hyphens=False,
    )


def _function_text(function: template_data.Function, indent: str) -> str:
    body = [f"  {line}" for line in function.body]
    return "\n".join(indent + line for line in (*function.comment, *function.head, *body, "}"))
