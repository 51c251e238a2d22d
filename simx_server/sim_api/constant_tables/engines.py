"""Numbers of parameters of the physics engines: of the engine itself, of joints and of shapes."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from .counting import counted

_BULLET = {
    **counted("bullet_global", "stepsize internalscalingfactor collisionmarginfactor", 1),
    **counted("bullet_global", "constraintsolvingiterations bitcoded constraintsolvertype", 1001),
    **counted("bullet_global", "fullinternalscaling computeinertias", 2001),
    **counted("bullet_joint", "stoperp stopcfm normalcfm free1 free2 pospid1 pospid2 pospid3", 3001),
    **counted(
        "bullet_body",
        "restitution oldfriction friction lineardamping angulardamping nondefaultcollisionmargingfactor "
        "nondefaultcollisionmargingfactorconvex",
        6001,
    ),
    **counted("bullet_body", "bitcoded", 7001),
    **counted(
        "bullet_body",
        "sticky usenondefaultcollisionmargin usenondefaultcollisionmarginconvex autoshrinkconvex",
        8001,
    ),
    **counted("bullet_constraintsolvertype", "sequentialimpulse nncg dantzig projectedgaussseidel"),
}

_ODE = {
    **counted("ode_global", "stepsize internalscalingfactor cfm erp", 9001),
    **counted("ode_global", "constraintsolvingiterations bitcoded randomseed", 10001),
    **counted("ode_global", "fullinternalscaling quickstep computeinertias", 11001),
    **counted("ode_joint", "stoperp stopcfm bounce fudgefactor normalcfm pospid1 pospid2 pospid3", 12001),
    **counted("ode_body", "friction softerp softcfm lineardamping angulardamping", 15001),
    **counted("ode_body", "maxcontacts", 16001),
}

_LOSSES = "loss stiffness damping frictioncoeff frictionmaxforce frictionloss"
_AXES = "primlinearaxis seclinearaxis primangularaxis secangularaxis normalangularaxis"


def _each(prefixes: str, suffixes: str) -> str:
    """Return all names made of a prefix and a suffix, those of one prefix together."""
    return " ".join(f"{prefix}{suffix}" for prefix in prefixes.split() for suffix in suffixes.split())


_VORTEX = {
    **counted(
        "vortex_global",
        "stepsize internalscalingfactor contacttolerance constraintlinearcompliance constraintlineardamping "
        "constraintlinearkineticloss constraintangularcompliance constraintangulardamping "
        "constraintangularkineticloss",
        18001,
    ),
    **counted("vortex_global", "bitcoded", 19001),
    **counted("vortex_global", "autosleep multithreading - - computeinertias", 20001),
    **counted(
        "vortex_joint",
        "lowerlimitdamping upperlimitdamping lowerlimitstiffness upperlimitstiffness lowerlimitrestitution "
        "upperlimitrestitution lowerlimitmaxforce upperlimitmaxforce motorconstraintfrictioncoeff "
        "motorconstraintfrictionmaxforce motorconstraintfrictionloss "
        + _each("p0 p1 p2 a0 a1 a2", _LOSSES)
        + " dependencyfactor dependencyoffset free1 free2 pospid1 pospid2 pospid3",
        21001,
    ),
    **counted(
        "vortex_joint",
        "bitcoded relaxationenabledbc frictionenabledbc frictionproportionalbc objectid dependentobjectid",
        22001,
    ),
    **counted("vortex_joint", "motorfrictionenabled proportionalmotorfriction", 23001),
    **counted(
        "vortex_body",
        f"{_each(_AXES, 'friction')} {_each(_AXES, 'staticfrictionscale')} compliance damping restitution "
        "restitutionthreshold adhesiveforce linearvelocitydamping angularvelocitydamping "
        f"{_each(_AXES, 'slide')} {_each(_AXES, 'slip')} autosleeplinearspeedthreshold "
        "autosleeplinearaccelthreshold autosleepangularspeedthreshold autosleepangularaccelthreshold skinthickness "
        "autoangulardampingtensionratio primaxisvectorx primaxisvectory primaxisvectorz",
        24001,
    ),
    **counted(
        "vortex_body",
        "primlinearaxisfrictionmodel seclinearaxisfrictionmodel primangulararaxisfrictionmodel "
        "secmangulararaxisfrictionmodel normalmangulararaxisfrictionmodel bitcoded autosleepsteplivethreshold "
        "materialuniqueid",
        25001,
    ),
    **counted(
        "vortex_body",
        "pureshapesasconvex convexshapesasrandom randomshapesasterrain fastmoving autoslip "
        "seclinaxissameasprimlinaxis secangaxissameasprimangaxis normangaxissameasprimangaxis autoangulardamping",
        26001,
    ),
    **counted("vortex_bodyfrictionmodel", "box scaledbox proplow prophigh scaledboxfast neutral none"),
}

_NEWTON = {
    **counted("newton_global", "stepsize contactmergetolerance", 27001),
    **counted("newton_global", "constraintsolvingiterations bitcoded", 28001),
    **counted("newton_global", "multithreading exactsolver highjointaccuracy", 29001),
    **counted("newton_joint", "dependencyfactor dependencyoffset pospid1 pospid2 pospid3", 30001),
    **counted("newton_joint", "objectid dependentobjectid", 31001),
    **counted("newton_body", "staticfriction kineticfriction restitution lineardrag angulardrag", 33001),
    **counted("newton_body", "bitcoded", 34001),
    **counted("newton_body", "fastmoving", 35001),
}

ENGINES: Mapping[str, int] = MappingProxyType({**_BULLET, **_ODE, **_VORTEX, **_NEWTON})
