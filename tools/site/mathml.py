# SPDX-License-Identifier: LGPL-3.0-or-later
"""Formulas of the site as MathML, which browsers typeset themselves: no script, no download."""

from __future__ import annotations

import re

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.writers.html5 import HTML5Translator

LOGGER = logging.getLogger(__name__)
TAG = re.compile(r"\\tag\{([^}]*)\}")


def mathml(translator: HTML5Translator, node: nodes.math | nodes.math_block) -> str:
    """A formula in MathML; one that cannot be read is a warning, which ends the build."""
    tex = TAG.sub("", node.astext())
    if r"\\" in tex and r"\begin" not in tex:
        tex = rf"\begin{{aligned}}{tex}\end{{aligned}}"
    try:
        return tex2mathml(tex, as_block=isinstance(node, nodes.math_block))
    except MathError as error:
        LOGGER.warning("formula: %s", error, location=node)
        return translator.encode(tex)


def visit_inline(translator: HTML5Translator, node: nodes.math) -> None:
    """Write a formula in a line of text."""
    translator.body.append(f'<span class="math">{mathml(translator, node)}</span>')
    raise nodes.SkipNode


def visit_block(translator: HTML5Translator, node: nodes.math_block) -> None:
    r"""Write a formula on a line of its own, with the number in its ``\tag``."""
    number = TAG.search(node.astext())
    label = f'<span class="eqno">({number[1]})</span>' if number else ""
    text = mathml(translator, node)
    translator.body.append(f'<div class="math">{text}{label}</div>\n')
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the renderer."""
    app.add_html_math_renderer("mathml", (visit_inline, None), (visit_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
