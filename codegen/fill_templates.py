# SPDX-License-Identifier: Apache-2.0
"""Views -> text, by the templates."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from hypgen.codegen.cpp import template_data

_TEMPLATES = Path(__file__).parent / "templates"


def render(
    header: template_data.Header,
    main: template_data.Main,
    project: template_data.Project,
    library: template_data.Library,
) -> dict[str, str]:
    """Return the files of a project, which builds a solver and libraries, keyed by their paths."""
    templates = {
        **_library_templates(project.stem),
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


def render_library(
    header: template_data.Header,
    main: template_data.Main,
    project: template_data.Project,
    library: template_data.Library,
) -> dict[str, str]:
    """Return the files of a project that are of its libraries, with a page for their users."""
    templates = {**_library_templates(project.stem), "README.md": "library_README.md.j2"}
    return _render(templates, header, main, project, library)


def _library_templates(stem: str) -> dict[str, str]:
    return {
        f"src/{stem}.hpp": "model.hpp.j2",
        "src/library.cpp": "library.cpp.j2",
        "src/shared.cpp": "shared.cpp.j2",
        "src/device.cu": "device.cu.j2",
        "src/device_digests.cu": "device_digests.cu.j2",
        f"include/{stem}.h": "library.h.j2",
        f"cmake/{stem}-config.cmake.in": "config.cmake.j2",
    }


def _render(
    templates: Mapping[str, str],
    header: template_data.Header,
    main: template_data.Main,
    project: template_data.Project,
    library: template_data.Library | None = None,
) -> dict[str, str]:
    environment = Environment(
        loader=FileSystemLoader(_TEMPLATES),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,
    )
    environment.filters["function_text"] = _function_text
    values = {"model": header, "main": main, "project": project, "library": library}
    return {path: environment.get_template(name).render(values) for path, name in templates.items()}


def _function_text(function: template_data.Function, indent: str) -> str:
    body = [f"  {line}" for line in function.body]
    return "\n".join(indent + line for line in (*function.comment, *function.head, *body, "}"))
