"""Constants for kinds of things: objects, sensors, joints, scripts, particles, textures, properties."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from .counting import counted

KINDS: Mapping[str, int] = MappingProxyType(
    {
        **counted(
            "sceneobject",
            "shape joint graph camera dummy proximitysensor visionsensor=9 mill=11 forcesensor light mirror octree "
            "pointcloud script marker customsceneobject",
        ),
        **counted("object", "octree_type pointcloud_type script_type marker_type", 15),
        **counted("light", "omnidirectional spot directional", 1),
        **counted("joint", "revolute prismatic spherical", 10),
        **counted("shape", "simple compound", 20),
        **counted("proximitysensor", "pyramid cylinder disc cone ray", 30),
        **counted("volume", "pyramid cylinder disc cone ray randomizedray"),
        **counted("parentingmode", "keeplocalpose keepworldpose assembly"),
        **counted("scripttype", "main simulation addon customization=6 sandbox=8 passive"),
        **counted("scripttype", "addonscript addonfunction jointctrlcallback contactcallback", 2),
        **counted("scripttype", "generalcallback=7 sandboxscript=8 threaded=0xf0"),
        "modelproperty_scripts_inactive": 0x200,
        **counted("scriptstate", "unloaded uninitialized initialized ended error=8 suspended=16"),
        **counted("lang", "undefined lua python", -1),
        **counted("scripttreetraversal", "reverse forward parent"),
        **counted("scriptdebug", "none syscalls vars_interval allcalls vars callsandvars"),
        **counted("scriptexecorder", "first normal last"),
        **counted("dummytype", "dynloopclosure dyntendon=7 default=8 neutral=8 assembly"),
        **counted(
            "dummy",
            "linktype_dynamics_loop_closure linktype_dynamics_force_constraint linktype_gcs_loop_closure "
            "linktype_gcs_tip linktype_gcs_target linktype_ik_tip_target linktype_reserved",
        ),
        **counted("jointdynctrl", "free force velocity=4 position=8 spring=12 callback=16"),
        **counted(
            "dynmat",
            "default highfriction lowfriction nofriction reststackgrasp foot wheel gripper floor",
            2310013,
        ),
        **counted("texturemap", "plane cylinder sphere cube"),
        **counted(
            "colorcomponent", "ambient ambient_diffuse=0 diffuse specular emission transparency auxiliary"
        ),
        **counted("textureapplymode", "modulate decal add"),
        **counted("materialcomponent", "diffuse lightdiffuse specular emission"),
        **counted(
            "rendermode",
            "opengl auxchannels colorcoded povray reserved extrenderer extrendererwindowed opengl3 opengl3windowed "
            "oglimg codedimg",
        ),
        **counted("forcesensorfilter", "average median"),
        **counted("imgcomb", "vertical horizontal"),
        **counted("particle", "points1 points2 points4 roughspheres spheres"),
        **counted(
            "particle",
            "respondable1to4=0x20 respondable5to8=0x40 particlerespondable=0x80 ignoresgravity=0x100 "
            "invisible=0x200 itemsizes=0x400 itemdensities=0x800 itemcolors=0x1000 cyclic=0x2000 "
            "emissioncolor=0x4000 water=0x8000 painttag=0x10000",
        ),
        **counted(
            "markertype", "points lines triangles spheres=7 squares=9 discs cubes cylinders custom tubes axes"
        ),
        **counted("markeropts", "local=1 cyclic=2 overlay=4"),
        **counted(
            "distcalcmethod", "dl dac max_dl_dac dl_and_dac sqrt_dl2_and_dac2 dl_if_nonzero dac_if_nonzero"
        ),
        **counted(
            "propertytype",
            "bool int float string buffer vector3 quaternion pose matrix3x3 matrix4x4 color floatarray table "
            "intarray vector2 intarray2 long null matrix array map handle handlearray stringarray group enum "
            "method=0xf0",
        ),
        **counted(
            "propertyinfo",
            "notwritable=1 notreadable=2 removable=4 modelhashexclude=8 deprecated=0x10 silent=0x20 constant=0x40 "
            "largedata=0x100",
        ),
        **counted(
            "propertyret",
            "invalidvalue invalidname corrupt typemismatch notremovable notwritable notreadable unknowntarget "
            "unknownproperty unavailable ok",
            -9,
        ),
        **counted("string", "text binary buffer"),
        **counted(
            "stackitem",
            "null double bool string table func userdat thread lightuserdat integer matrix quaternion pose handle "
            "color handlearray",
        ),
        **counted(
            "objecttype", "sceneobject=109 collection=115 script=117 texture=120 mesh=122 interfacestack"
        ),
        **counted("pathplanning", "holonomic reserved nonholonomic"),
        **counted("holonomicpathplanning", "xy xg xyz xyg abg xyzg xabg xyabg xyzabg"),
        **counted(
            "pathproperty",
            "show_line=1 show_orientation=2 closed_path=4 automatic_orientation=8 invert_velocity=0x10 "
            "infinite_acceleration=0x20 flat_path=0x40 show_position=0x80 auto_velocity_profile_translation=0x100 "
            "auto_velocity_profile_rotation=0x200 endpoints_at_zero=0x400 keep_x_up=0x800",
        ),
    }
)
