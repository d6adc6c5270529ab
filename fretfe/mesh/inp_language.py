# SPDX-License-Identifier: LGPL-3.0-or-later
"""Keywords and parameters of Abaqus and CalculiX input files, and what they may be shortened to.

Both may be abbreviated as long as no other one begins in the same way, blanks and case do not count
(Abaqus Analysis User's Guide, Input syntax rules).
"""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

# All parameters of the keywords that are read: any other one is a mistake, or asks for something
# that is not known here. Names are written without blanks.
PARAMETERS: dict[str, tuple[str, ...]] = {
    "INCLUDE": ("INPUT", "PASSWORD"),
    "NODE": ("INPUT", "NSET", "SYSTEM"),
    "ELEMENT": ("ELSET", "FILE", "INPUT", "OFFSET", "SOLIDELEMENTNUMBERING", "TYPE"),
    "NSET": ("ELSET", "GENERATE", "INSTANCE", "INTERNAL", "NSET", "UNSORTED"),
    "ELSET": ("ELSET", "GENERATE", "INSTANCE", "INTERNAL", "UNSORTED"),
    "SURFACE": (
        *("BEAMTYPE", "COMBINE", "CROP", "DEFINITION", "FILLETRADIUS", "INTERNAL", "MAXRATIO"),
        *("NAME", "NOOFFSET", "NOTHICK", "PROPERTY", "REGIONTYPE", "SCALETHICK", "TRIM", "TYPE"),
    ),
    "PART": ("INTERNAL", "NAME"),
    "ENDPART": (),
    "ASSEMBLY": ("NAME",),
    "ENDASSEMBLY": (),
    "INSTANCE": ("INSTANCE", "INTERNAL", "LIBRARY", "NAME", "PART"),
    "ENDINSTANCE": (),
    "CONTACTPAIR": (
        *("ADJUST", "ADJUSTMENT", "BLENDING", "CPSET", "EXTENSIONZONE", "GEOMETRICCORRECTION"),
        *("HCRIT", "INTERACTION", "MECHANICALCONSTRAINT", "MINIMUMDISTANCE", "NOTHICKNESS", "OP"),
        *("SLIDEDISTANCE", "SMALLSLIDING", "SMOOTH", "SUPPLEMENTARYCONSTRAINTS", "TIED"),
        *("TRACKING", "TYPE", "WEIGHT"),
    ),
    "CONTACTINITIALIZATIONDATA": (
        *("INITIALCLEARANCE", "INTERFERENCEFIT", "NAME", "SEARCHABOVE", "SEARCHBELOW"),
        *("SEARCHNSET", "SECTIONTYPE", "STEPFRACTION", "TIED"),
    ),
    "SURFACEBEHAVIOR": (
        *("AUGMENTEDLAGRANGE", "DIRECT", "NOSEPARATION", "PENALTY", "PRESSURE-OVERCLOSURE"),
        *("PRESSUREDEPENDENCE", "UNCOUPLED"),
    ),
    "MATERIAL": ("NAME", "RTOL", "SRATEFACTOR", "STRAINRATEREGULARIZATION"),
}
# The same of those whose other parameters say nothing of the mesh or of constants: they may have
# more.
OPEN_PARAMETERS: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(
        ("SOLIDSECTION", "SHELLSECTION", "MEMBRANESECTION"),
        (
            *("BULKVISCOSITY", "COMPOSITE", "CONTROLS", "DENSITY", "ELSET", "LAYUP", "MATERIAL"),
            *("MEMBRANETHICKNESS", "NODALTHICKNESS", "OFFSET", "ORDER", "ORIENTATION", "POISSON"),
            *("REFNODE", "SECTIONINTEGRATION", "SHELLTHICKNESS", "STACKDIRECTION", "SYMMETRIC"),
            *("TEMPERATURE", "THICKNESSMODULUS"),
        ),
    ),
    "ELASTIC": ("COMPRESSIONFACTOR", "DEPENDENCIES", "DISTRIBUTION", "MODULI", "TYPE"),
    "DENSITY": ("DEPENDENCIES", "DISTRIBUTION", "POREFLUID"),
    "EXPANSION": ("DEPENDENCIES", "POREFLUID", "TYPE", "USER", "ZERO"),
    "SURFACEINTERACTION": ("NAME", "PADTHICKNESS", "UNSYMM", "USER"),
    "FRICTION": ("ROUGH", "LAGRANGE", "SLIPTOLERANCE", "TAUMAX", "USER"),
    "AMPLITUDE": ("DEFINITION", "INPUT", "NAME", "SMOOTH", "TIME", "VALUE"),
    "STEP": ("AMPLITUDE", "INC", "NAME", "NLGEOM", "PERTURBATION", "UNSYMM"),
    **dict.fromkeys(("STATIC", "VISCO"), ("DIRECT", "RIKS", "STABILIZE")),
    "ENDSTEP": (),
    "TIE": (
        *("ADJUST", "CONSTRAINTRATIO", "CYCLICSYMMETRY", "NAME", "NOROTATION", "NOTHICKNESS"),
        *("POSITIONTOLERANCE", "TIEDNSET", "TYPE"),
    ),
    "CYCLICSYMMETRYMODEL": ("CHECK", "ELSET", "N", "NGRAPH", "TIE"),
    "HEADING": (),
    "BOUNDARY": ("AMPLITUDE", "FIXED", "OP", "SUBMODEL", "TYPE", "USER"),
    **dict.fromkeys(("CLOAD", "DLOAD", "DSLOAD"), ("AMPLITUDE", "FOLLOWER", "OP", "USER")),
    "RIGIDBODY": (
        *("ANALYTICALSURFACE", "DENSITY", "ELSET", "ISOTHERMAL", "NSET", "OFFSET", "PINNSET"),
        *("POSITION", "REFNODE", "ROTNODE", "THICKNESS", "TIENSET"),
    ),
    "COUPLING": ("ALPHA", "CONSTRAINTNAME", "INFLUENCERADIUS", "ORIENTATION", "REFNODE", "SURFACE"),
    "KINEMATIC": (),
    "DISTRIBUTING": ("COUPLING", "WEIGHTINGMETHOD"),
    "KINEMATICCOUPLING": ("ORIENTATION", "REFNODE"),
    "DISTRIBUTINGCOUPLING": ("ELSET", "ORIENTATION"),
}
# Keywords of contacts and steps: they say nothing of the mesh, but what a case could be.
ANALYSIS = (
    *("SURFACEINTERACTION", "FRICTION", "CONTACTPAIR", "AMPLITUDE", "STEP", "STATIC", "VISCO"),
    *("ENDSTEP", "BOUNDARY", "CLOAD", "DLOAD", "DSLOAD"),
)
# Keywords by which a node moves a surface, or spreads forces over it.
REFERENCES = (
    *("RIGIDBODY", "COUPLING", "KINEMATIC", "DISTRIBUTING", "KINEMATICCOUPLING"),
    "DISTRIBUTINGCOUPLING",
)
# Keywords that change nodes, elements or what numbers mean, or that join parts: without them the
# model would be another one. And what to do instead.
_WRITTEN_OUT = "write out all nodes and elements"
JOINED = (
    "it joins nodes or parts, which would come apart here: mesh them as one part with common "
    "nodes, or make them bodies of their own in contact"
)
# What has a stiffness that no elements of bodies have.
_STIFFNESS = (
    "its stiffness is not that of any element of a body, and a model without it would be another "
    "one: mesh what it stands for with elements of bodies"
)
_SPRING = (
    "springs and connectors are not known, and a model without them would be another one: mesh "
    "what they stand for, or put a support or a force in their place"
)
_RIGID = "rigid bodies need a mesh: mesh it, with a large Young's modulus, or hold what it holds"
_CUT = (
    "cut the mesh of the bolt in two there, so that both sides have nodes and a surface of their "
    "own, tie these by [ties.NAME], and tighten the bolt by a load of type pretension of that tie"
)
REFUSED = {
    "PRE-TENSIONSECTION": _CUT,
    **dict.fromkeys(
        (
            *("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM", "IMPERFECTION"),
            *("SYMMETRICMODELGENERATION", "IMPORT", "MAP", "PARAMETER", "MODELCHANGE"),
        ),
        _WRITTEN_OUT,
    ),
    **dict.fromkeys(
        (
            *("MPC", "EQUATION", "NETWORKMPC", "EMBEDDEDELEMENT", "SHELLTOSOLIDCOUPLING"),
            *("FASTENER", "BONDEDREGION", "COHESIVEBEHAVIOR"),
        ),
        JOINED,
    ),
    **dict.fromkeys(
        ("SUBSTRUCTUREGENERATE", "SUBSTRUCTUREPROPERTY", "MATRIXASSEMBLE", "USERELEMENT"),
        _STIFFNESS,
    ),
    **dict.fromkeys(("SPRING", "DASHPOT", "JOINT", "RELEASE", "CONNECTORSECTION"), _SPRING),
    **dict.fromkeys(("RIGIDSURFACE", "IMPLICITRIGIDBODY"), _RIGID),
    "DISPLAYBODY": "it is shown and not solved: leave its instance out",
}
# Keywords that are not read and change what a model does: a case without them is another one.
ACTING = (
    *("CHANGEFRICTION", "CLEARANCE", "CONTACT", "CONTACTINTERFERENCE", "FOUNDATION"),
    *("INITIALCONDITIONS", "SUBMODEL", "TEMPERATURE", "TRANSFORM"),
)
# A keyword that is not used and with which others begin: written out, it is no abbreviation.
_WHOLE = ("CONTACT",)
KEYWORDS = (*PARAMETERS, *OPEN_PARAMETERS, *REFUSED, *_WHOLE)
# Other keywords of Abaqus and CalculiX that are like one of these.
_ALIKE = frozenset(
    (
        *("BOUNDARYF", "CHANGESOLIDSECTION", "CHANGESURFACEBEHAVIOR", "CLOADF", "DLOADF", "SLOAD"),
        *("CONNECTORFRICTION", "CONNECTORMOTION", "CONNECTORSTOP", "CONTACTFILE", "CONTACTPRINT"),
        *("CONTACTINITIALIZATIONASSIGNMENT", "CONTACTSTABILIZATION", "DESIGNPARAMETER"),
        *("DISTRIBUTION", "DISTRIBUTIONTABLE", "EPJOINT", "FLUIDEXPANSION", "FLUIDSECTION"),
        *("GEOSTATIC", "HYPOELASTIC", "IMPORTELSET", "IMPORTNSET", "PLASTIC", "PLASTICM1"),
        *("PLASTICM2", "SELECTCYCLICSYMMETRYMODES", "SHELLGENERALSECTION", "SUBSTRUCTURECOPY"),
        *("SUBSTRUCTUREDELETE", "SUBSTRUCTUREDIRECTORY", "SUBSTRUCTUREPATH", "SURFACEFLAW"),
        *("SURFACESECTION", "USERMATERIAL", "USERSECTION", "VISCOUS"),
    )
)


def squeezed(text: str) -> str:
    """A keyword, parameter or value in capitals and without blanks, which do not count."""
    return "".join(text.upper().split())


def whole_keyword(word: str) -> str:
    """The keyword that an abbreviation stands for; itself where it stands for none that is known.

    Raises:
        ValueError: several begin so, or it is a known one misspelt.
    """
    found = _beginning(word, dict.fromkeys(KEYWORDS))
    if len(found) > 1:
        raise ValueError(
            f"expected a keyword, found *{word}, with which {', '.join(found)} begin: write it out"
        )
    if not found and word not in _ALIKE:
        if near := _meant(word, KEYWORDS):
            raise ValueError(f"unknown keyword; did you mean *{near[0]}?")
    return found[0] if found else word


def whole_parameter(word: str, parameter: str) -> str:
    """The parameter of a keyword, both squeezed, that an abbreviation stands for.

    Raises:
        ValueError: several begin so, it is not among all that the keyword has, or a known one
            misspelt.
    """
    known = PARAMETERS.get(word, OPEN_PARAMETERS.get(word))
    found = _beginning(parameter, known or ())
    if known is None or len(found) == 1:
        return found[0] if found else parameter
    if not found and word in OPEN_PARAMETERS:
        if not (near := _meant(parameter, known)):
            return parameter
        raise ValueError(f"unknown parameter {parameter}; did you mean {near[0]}?")
    raise ValueError(
        f"expected parameters {', '.join(known) or '(none)'}, found {parameter}"
        + (f", with which {' and '.join(found)} begin" if found else "")
    )


def whole_value(value: str, choices: Iterable[str]) -> str:
    """The one of some values that an abbreviation stands for; itself, squeezed, if there is none.

    Raises:
        ValueError: several begin so.
    """
    value = squeezed(value)
    found = _beginning(value, choices)
    if len(found) > 1:
        raise ValueError(f"found {value}, with which {' and '.join(found)} begin: write it out")
    return found[0] if found else value


def _meant(word: str, known: tuple[str, ...]) -> list[str]:
    """The known words that are like a misspelt one, the nearest first."""
    mixed = [each for each in known if sorted(each) == sorted(word)]
    return mixed or get_close_matches(word, known, n=1, cutoff=0.75)


def _beginning(word: str, known: Iterable[str]) -> list[str]:
    """The known words that a word is or may stand for."""
    known = tuple(known)
    return [word] if word in known else [each for each in known if each.startswith(word)]
