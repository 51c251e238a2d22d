"""Random mechanisms: chains of joints under all rules, with tendons, contacts, force sensors and loose boxes."""

from __future__ import annotations

import random

_OPTIONS = (
    'integrator="implicitfast" cone="elliptic" noslip_iterations="3" impratio="10"',
    'integrator="implicitfast" cone="elliptic" noslip_iterations="2" jacobian="sparse"',
    'integrator="Euler" cone="pyramidal"',
    'integrator="implicit" cone="elliptic"',
    'integrator="RK4" cone="elliptic"',
)

_NOTES = (
    "motor=on control=position P={p} upper_velocity={v} max_force={f}",
    "motor=on control=position P={p} I={i} D={d} upper_velocity={v} max_force={f}",
    "motor=on control=position P={p} upper_velocity={v} max_force={f} cyclic=yes",
    "motor=on control=velocity target_velocity={w} max_force={f}",
    "motor=on control=velocity lock=on max_force={f}",
    "motor=on control=force max_force=-{f}",
    "motor=on control=spring K={k} C={c} max_force={f}",
    "motor=on control=spring K={k} C={c} max_force={f} cyclic=yes",
    "motor=on control=spring K=1e7 C={c} max_force={f} target_velocity={v}",
    "motor=on control=spring K=1e7 C={c} max_force={f} target_velocity={v} cyclic=yes",
    "motor=off rewind=yes",
    "mode=motion target_velocity={w}",
    "mode=passive",
    "mode=passive hybrid=yes P={p}",
    "mode=dependent master={master} multiplication={w} offset={d}",
    "mode=dependent master={master} multiplication={w} hybrid=yes P={p}",
)


def mechanism(seed: int) -> str:
    """Return a scene as MJCF. Equal seeds give equal scenes."""
    chance = random.Random(seed)
    bodies: list[str] = []
    notes: list[str] = []
    actuators: list[str] = []
    names: list[str] = []
    sites: list[str] = []
    for chain in range(chance.randint(1, 4)):
        depth = chance.randint(1, 4)
        opened = ""
        for link in range(depth):
            name = f"j{chain}_{link}"
            opened += _link(chance, name, f"{0.5 * chain} 0 0.25" if link == 0 else "0 0 0.15")
            opened += f'<site name="s_{name}"/>'
            sites.append(f"s_{name}")
            kind = chance.choice(("hinge", "hinge", "slide", "ball"))
            limited = kind == "slide" or chance.random() < 0.4
            opened += (
                f'<joint name="{name}" type="{kind}" axis="{chance.choice(("1 0 0", "0 1 0", "0 0 1"))}"'
            )
            opened += ' range="-1.5 1.5" limited="true"' if limited and kind != "ball" else ""
            if kind != "ball" and chance.random() < 0.3:
                opened += f' frictionloss="{chance.choice((0.1, 5))}"'
            if kind != "ball" and chance.random() < 0.2:
                opened += ' actuatorfrcrange="-8 8"'
            opened += f' damping="{chance.choice((0, 0.1))}"/>'
            if kind != "ball":
                _drive(chance, name, kind, names, notes, actuators)
                names.append(name)
        bodies.append(opened + "</body>" * depth)
    for number in range(chance.randint(0, 3)):
        bodies.append(
            f'<body pos="{0.5 * number} {chance.uniform(-0.1, 0.1)} {chance.uniform(0.7, 1)}"><freejoint/>'
            f'<geom type="box" size="0.08 0.08 0.05" mass="{chance.uniform(0.1, 2)}"/></body>'
        )
    sensors = "".join(
        f'<force site="{site}"/><torque site="{site}"/>' for site in sites if chance.random() < 0.2
    )
    return f"""
<mujoco model="random {seed}">
  <option timestep="{chance.choice((0.001, 0.002, 0.005))}" {chance.choice(_OPTIONS)}>
    <flag sleep="{chance.choice(("disable", "disable", "enable"))}"/></option>
  <default><geom friction="{chance.choice((0.3, 0.71, 1.2))} 0.005 0.0001"/></default>
  <worldbody><geom type="plane" size="9 9 1"/>{"".join(bodies)}</worldbody>
  {_tendon(chance, names, notes, actuators)}
  <sensor>{sensors}</sensor>
  <actuator>{"".join(actuators)}</actuator>
  <custom><numeric name="simx:time_step" data="0.02"/>{"".join(notes)}</custom>
</mujoco>"""


def _link(chance: random.Random, name: str, place: str) -> str:
    shape = chance.choice(
        ('type="capsule" fromto="0 0 0 0 0 0.1" size="0.04"', 'type="box" size="0.05 0.05 0.05"')
    )
    return f'<body name="b_{name}" pos="{place}"><geom {shape} mass="{chance.uniform(0.05, 2):.3f}"/>'


def _drive(
    chance: random.Random, name: str, kind: str, masters: list[str], notes: list[str], actuators: list[str]
) -> None:
    gear = chance.choice((1, 1, -2.5))
    servo = chance.choice(("motor", "motor", 'velocity kv="20"', 'position kp="50" kv="2"'))
    word, _, rest = servo.partition(" ")
    if chance.random() < 0.4:
        actuators.append(f'<{word} joint="{name}" gear="{gear}" {rest}/>')
    note = chance.choice(_NOTES if masters else _NOTES[:-2])
    if kind == "slide":
        note = note.replace(" cyclic=yes", "").replace(" rewind=yes", "")
    filled = note.format(
        p=chance.choice((0.05, 0.1, 1)),
        i=chance.choice((0, 0.01)),
        d=chance.choice((0, 0.02)),
        v=round(chance.uniform(0.2, 5), 3),
        w=round(chance.uniform(-2, 2), 3),
        f=chance.choice((1, 20, 300)),
        k=chance.choice((5, 200)),
        c=chance.choice((0, 1)),
        master=chance.choice(masters) if masters else "",
    )
    notes.append(f'<text name="simx:joint:{name}" data="{filled}"/>')


def _tendon(chance: random.Random, names: list[str], notes: list[str], actuators: list[str]) -> str:
    if len(names) < 2 or chance.random() < 0.5:
        return ""
    one, other = chance.sample(names, 2)
    friction = chance.choice(("", 'frictionloss="0.5"'))
    actuators.append('<velocity tendon="rope" kv="50" forcerange="-20 20"/>')
    control = chance.choice(("control=velocity lock=on target_velocity=0.3", "control=position P=0.1"))
    notes.append(
        f'<text name="simx:joint:rope" data="motor=on {control} upper_velocity=0.5 offset=-0.2 parent=b_{one}"/>'
    )
    return (
        f'<tendon><fixed name="rope" {friction}><joint joint="{one}" coef="1"/><joint joint="{other}" coef="-0.7"/>'
        "</fixed></tendon>"
    )
