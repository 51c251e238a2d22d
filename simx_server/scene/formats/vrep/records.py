"""The list of all records that are read: by the list in which a tag stands, what its payload holds.

A payload's form is a word of counted letters, as in Python's `struct`, without alignment, little-endian:

| letter | in the file |
|---|---|
| `r` | real number: float32 under this tag, float64 under its twin, `_` and the tag's last two letters |
| `x` | the same, of which unused ones may be anything, also NaN |
| `f`, `d` | real number that is always float32, always float64, and has no twin |
| `i`, `H`, `B`, `q` | whole number: int32, uint16, uint8, int64 |
| `s` | text: int32 length in bytes, and the bytes |
| `*` before `f`, `r`, `i` | as many as the payload holds; last in the form |
| `array` | parameters of a physics engine: int32 numbers of reals and of ints, the reals (`r`), the ints |
| `raw` | bytes |
| `list NAME` | records again, of the list NAME below |

A tag means different things in different lists, so it is looked up together with its list. Other tags are skipped.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

_COLOR: Final = "15f"

RECORDS: Final[Mapping[str, Mapping[str, str]]] = {
    # Before NXT, in each object.
    "object": {
        "Ids": "2i",  # own handle, parent's handle or -1
        "Cfq": "7r",  # pose relative to the parent: quaternion, position
        "Nme": "s",
        "Ali": "s",
        "Lar": "H",  # visibility layers
        "Omp": "i",  # properties
        "Mpo": "i",  # model properties
        "Va3": "B",  # 1: model base
        "Va2": "B",
        "Var": "B",
        "Op2": "i",  # flags of the user interface
        "Cor": "i",  # place among the siblings, -1: none
        "Sfa": "r",  # size factor
        "Sfb": "3r",  # size factors along x, y, z
        "Rst": "s",  # extension string
        "Ack": "s",
        "Lsp": "list parameters",  # user parameters; up to V-REP 3.6.1 those of the script, `Prm`
        "Crh": "raw",  # references without a tag: int32 count; each int32 type, handle, 0
        "Cr2": "raw",  # of a tag: text, int32 count; each int32 handle
        "Cda": "list custom data",
        "Cod": "list custom data",
    },
    "custom data": {
        "Cdt": "raw",  # text, int32 length, bytes
        "Dat": "raw",  # int32 header, int32 length, bytes
    },
    # After NXT, by the kind of object.
    "SHP": {
        "Ge2": "list geometry",
        "Mat": "list surface",
        "Dc2": "H",  # respondable mask
        "Idv": "6r",  # first velocity
        "Sss": "B",  # 128 dynamic, 64 starts asleep
        "Ss3": "B",  # 1 respondable
        "Ss2": "B",
    },
    "JNT": {
        "Jtt": "i",  # type
        "Prt": "r",  # position
        "Jst": "4r",  # motion of a spherical joint, a quaternion
        "Jsp": "r",  # pitch of a screw, m per rad
        "Sld": "d",  # lead of a screw, m per turn
        "Pmr": "2r",  # minimum, range
        "Jmd": "i",  # mode
        "Va9": "B",  # 1 cyclic, 16 motor on, 32 position control, 64 hybrid, 128 spring
        "Vaa": "B",  # 2 locked at target velocity 0
        "Dcm": "i",  # way of control
        "Dmp": "2r",  # target velocity, maximum force
        "Dtp": "r",  # target position
        "Ulv": "f",  # limit of velocity
        "Ruc": "3r",  # limits of velocity, acceleration, jerk
        "Dp2": "3f",  # P, I, D
        "Dpc": "3f",
        "Spp": "2r",  # spring constant, damping
        "Jdt": "i2r",  # master, factor, offset
        "BtN": "array",
        "OdN": "array",
        "Nw1": "array",
        "Vo2": "array",
        "Mj3": "array",
        "Ikw": "r",  # weight in inverse kinematics
        "Arg": "2r",  # length and diameter of the drawing
    },
    "DMY": {
        "Lli": "i",  # linked dummy or -1
        "Dl2": "i",  # type of the link
        "Dy2": "r",  # size
        "Cl0": "list color",
        "Var": "B",  # 2: follows its parent path
        "Po5": "2r",  # offset on the path, step of copies
    },
    "RSN": {
        "Ccp": "4r",  # orthographic size, angle, near, far
        "Res": "2i",  # width, height
        "Si2": "r",  # size
        "Siz": "3f",
        "Db2": "3f",  # default colour
        "Rmd": "i",  # render mode
        "Dox": "i",  # what is rendered
        "Va3": "B",  # 1 perspective, 2 explicit, 128 background of the environment
        "Va2": "B",  # 1 external image, 2 ignores RGB, 4 ignores depth, 16 no statistics
        "Cfr": "list filters",
    },
    "filters": {"Sfr": "list filter"},
    "filter": {
        "Sft": "3i",  # type, header, id
        "Sfe": "B",  # 1 enabled
        "Pai": "i*i",  # count, numbers
        "Paf": "i*f",
        "Pab": "raw",
    },
    "SNR": {
        "Snt": "i",  # method
        "Vod": "list volume",
        "Pr4": "B",  # 2 closest, 4 checks the angle, 16 not the front, 32 not the back, 128 explicit
        "Al2": "r",  # largest angle
        "Sns": "r",  # size
        "Sox": "i",  # what is detected
        "Sst": "i",  # kind of detectable
        "Rad": "2i",  # rays of randomized detection, and how many of them must meet something
    },
    "volume": {
        "Snt": "i",  # type
        "Ss3": "9x",  # offset, range, sizes, radii, angle
        "Ssi": "4i",  # faces
        "Par": "B",  # 1 minimum distance on
        "Wtf": "x",  # minimum distance
        "Sia": "x",  # inside gap
    },
    "FSE": {
        "Tre": "2fi",  # force, torque, violations
        "Tri": "2ri",
        "Vab": "B",  # 1 force threshold on, 2 torque
        "Fil": "2i",  # samples, kind
        "Siz": "r",
    },
    "CMA": {
        "Cp3": "2r",  # orthographic size, angle
        "Ccp": "2r",  # near, far
        "Cp4": "ir",  # tracked object, size
        "Ca2": "B",  # 3 orthographic
        "Cpm": "i",  # 1 perspective, 0 orthographic, -1 as the view wants
    },
    "LGT": {
        "Cp2": "2ir",  # type, exponent, size
        "Cp3": "r",  # half angle of a spot
        "Caf": "3r",  # attenuation
        "Cas": "B",  # 1 on
        "Cl2": "list color",
    },
    "PAT": {
        "Ntp": "list path points",
        "Var": "B",  # 1 drawn as a body
        "Pss": "f",  # scale of the cross-section
        "Sha": "fi",  # least distance between two sections, type of the section
        "Sec": "i*f",  # count, coordinates
        "Scl": "list color",
    },
    "path points": {
        "At2": "i",  # attributes
        "Si2": "if",  # width of the line, size of the points
        "Cl0": "list color",
        "Jm2": "2f",  # position, nominal velocity
        "Av3": "fi",  # metres per radian, method of lengths
        "Av9": "f",  # metres per unit of virtual distance
        "Pat": "list path point",
    },
    "path point": {
        "At2": "9rir",  # position, quaternion, two factors, points, velocity
        "At3": "f",  # virtual distance
        "At4": "H4f",  # flags, channels
    },
    "MPL": {
        "Nme": "s",
        "Oid": "i",
        "Jhn": "i*i",  # count, joints
        "Ikg": "i",  # group of inverse kinematics
        "Ety": "4i",  # robot, obstacles, two entities of the robot that must not collide with each other
        "Cdt": "2f",  # least distance of the first two, of the last two
        "Tmc": "4f",  # weights of x, y, z and the angle of the tip
        "Jmc": "i*f",  # count, weights of the joints
    },
    "PPL": {
        "Idx": "3i",  # path, robot, obstacles
        "Gid": "i",  # goal
        "Pod": "i",  # start
        "Ppt": "i",  # kind of planning
        "Ttp": "i",  # type
        "Rn2": "8f",  # least value and extent of x, y, z, angle
        "Nme": "s",
        "Oid": "i",
        "Mxt": "f",  # longest duration
    },
    "GRH": {
        "Ghg": "r",  # size
        "Gbv": "2i",  # capacity, points
        "Gps": "B",  # 0x10 explicit
        "Ghd": "list stream",
        "Dst": "list stream",
        "Gh2": "list curve",
        "Gh3": "list curve",
    },
    "curve": {
        "Nme": "s",
        "Did": "3i",  # streams, -1 for none
    },
    "stream": {
        "Nme": "s",
        "Oid": "i",
        "Dt2": "3i",  # kind, object, -1
        "Col": "3f",
    },
    "MIL": {"Vod": "list volume"},
    "MIR": {"Msz": "2f"},
    "OCT": {
        "Siz": "ri",  # edge of the cells
        "Mm2": "6f",  # bounds
        "Co2": "raw",  # cells, see decoding/clouds.py
    },
    "PTC": {
        "Siz": "ri",  # largest edge of the cells
        "Mmd": "6f",  # bounds
        "Co2": "raw",
    },
    "SCT": {"Soo": "list script"},
    "MKR": {},
    "CSO": {},
    # Geometry.
    "geometry": {"Gst": "list leaf", "Gsg": "list group"},
    "group": {
        "Geo": "list leaf",
        "Wrp": "list group",
        "Mas": "r",
        "Ine": "10r",  # position, quaternion, moments divided by the mass
        "Com": "3d",  # centre of mass, since CoppeliaSim 4.5
        "Imx": "9d",  # moments as a matrix, divided by the mass
        "Dmi": "i",  # material
        "Var": "B",  # 4 convex
    },
    # After the first EOO of a leaf; before it there is what a group has.
    "leaf": {
        "Ppr": "i3r",  # primitive, size
        "Ppf": "7r",  # pose: position, quaternion
        "Vev": "i",
        "Inv": "i",
        "Nov": "i",
        "Ver": "raw",
        "In2": "raw",
        "Ind": "raw",
        "No2": "raw",
        "Nor": "raw",
        "Cl0": "list color",
        "Var": "B",  # 2 back faces culled, 4 wireframe
        "Va2": "B",  # 1 convex
        "Gsa": "ri",  # shading angle
        "Toj": "list texture use",
        "Hfd": "2i*r",  # columns, rows, heights
    },
    "texture use": {
        "Tob": "2i2r",  # texture, projection, sizes
        "Trc": "7r",  # frame: quaternion, position
        "Ftc": "raw",  # float32 u, v of each corner
        "Bst": "B",
    },
    "VIN": {"Ver": "raw", "In2": "raw", "Ind": "raw", "No2": "raw", "Nor": "raw"},
    "color": {
        "Cl3": _COLOR,
        "Cl2": _COLOR,
        "Cls": "12f",
        "Var": "B",  # 4 opaque
        "Trf": "f",  # opacity
        "Sh2": "i",  # shininess
        "Cnm": "s",
    },
    "surface": {
        "Ipa": "i",
        "Gon": "s",
        "BuN": "array",
        "Bul": "4f",  # restitution, friction, linear and angular damping
        "OdN": "array",
        "Od2": "i5f",
        "Nw1": "array",
        "Vo4": "array",
        "Mj1": "array",
    },
    # The rest of the file.
    "TEX": {
        "Ipa": "3i",  # id, width, height
        "Bst": "B",  # 1 RGBA
        "Img": "raw",
    },
    "script": {
        "Si2": "3i",  # id, object, type
        "Coc": "i",  # object
        "Coi": "i",  # joint of a joint control call-back script, -1 for other scripts
        "Va2": "B",  # 1 threaded, 2 disabled, 8: the simulator's own main script
        "Seo": "i",  # 0 first among siblings, 1 normal, 2 last
        "Ttd": "i",  # 0 after the scripts below, 1 before them, 2 as the script above; up to CoppeliaSim 4
        "Ste": "raw",
        "Lne": "s",
        "Prm": "list parameters",
    },
    "parameters": {"Par": "raw"},
    "SIM": {
        "St3": "r",  # time step
        "St2": "q",  # in microseconds
        "Sts": "f",
        "Spi": "i",  # 5: the time step above; 0 to 4: another one, whatever is above
        "Ss2": "B",  # 1 real time
    },
    "DYN": {
        "En3": "i3ri",  # engine, gravity, preset
        "En2": "i3fi",
        "Eng": "i3fi",
        "Ver": "i",  # 283 for Bullet 2.83; 0 for 2.78
        "Stp": "r",  # dynamics step
        "BuN": "array",  # the first real number is the dynamics step, in all of these
        "OdN": "array",
        "Nw1": "array",
        "Vo5": "array",
        "Bul": "f",
        "Ode": "f",
        "Var": "B",  # 1 on
    },
    "ENV": {
        "Clc": "3f",
        "Cld": "3f",
        "Al2": "3f",
        "Alc": "3f",
        "Fbg": "3f",  # colour of the fog
        "Ack": "s",
        "Vil": "H",
    },
    "SET": {"Al2": "H"},
    "GRP": {"Grn": "s", "Gix": "i", "Par": "B", "Asg": "list member"},
    "member": {
        "Obj": "2i",
        "Gty": "B",
        "Var": "B",  # 1 additive
    },
    "COL": {"Inx": "3i", "Nme": "s", "Par": "B"},
    "DST": {"Inx": "3i", "Nme": "s", "Par": "B", "Var": "B", "Trh": "f"},
    "IKO": {
        "Oid": "i",
        "Nme": "s",
        "Mit": "i",
        "Dpg": "r",
        "Cmt": "i",
        "Doo": "i",  # the group whose failure it waits for
        "Var": "B",
        "Ike": "list IK element",
    },
    "IK element": {
        "Ik2": "2i",
        "Ctr": "i",
        "Pr2": "2f",
        "Wgt": "2f",
        "Var": "B",
    },
    "BBK": {
        "Bkh": "i",
        "Att": "i",
        "Bkn": "s",
        "Bks": "2i",
        "Aoi": "i",
        "Btn": "list button",
    },
    "button": {"Bva": "raw", "_va": "raw", "Bnc": "9f"},
    "CDA": {"Cdt": "raw"},
    "CDS": {"Dat": "raw"},
    "MTC": {"Tm2": "raw"},
    "BBC": {"Mo2": "11r"},
}
