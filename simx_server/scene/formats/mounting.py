"""Mount grippers on arms: `simx:mount:NAME` puts a body onto a site when a file is read.

A model cannot be included in the middle of another one; so a scene includes both and names the site::

    <text name="simx:mount:RG2" data="on=UR10_connection"/>

NAME, a body at the top with all below it, moves under the site's body with its frame on the site's, `ahead=` metres
along the site's z; it loses its free joint. The effect is the same as setting that parent in a running scene, and can
be undone in the same way.
"""

from __future__ import annotations

import mujoco

from simx_server.scene.editing.transplant import move_body
from simx_server.scene.poses.poses import Pose, add, rotate

from .annotations import PREFIX, Annotations, SceneError

KIND = "mount"


def mount_bodies(spec: mujoco.MjSpec, annotations: Annotations) -> set[str]:
    """Execute the annotations of this kind, and remove them; return the names of the mounted bodies. Raises SceneError.

    All elements of the spec must have names.
    """
    notes = {name: kinds.pop(KIND) for name, kinds in annotations.objects.items() if KIND in kinds}
    if not notes:
        return set()
    model = spec.compile()
    for name, note in notes.items():
        element, site = f"{PREFIX}{KIND}:{name}", note.get("on")
        body = spec.body(name)
        if body is None or body.parent.name != "world":
            raise SceneError(f"text '{element}' is for a body at the top of the scene; '{name}' is none")
        if not isinstance(site, str) or spec.site(site) is None:
            raise SceneError(f"text '{element}' needs on=, the name of a site; '{site}' is none")
        index = model.site(site).id
        holder = int(model.site_bodyid[index])
        if int(model.body_rootid[holder]) == model.body(name).id:
            raise SceneError(f"text '{element}' has on={site}, which hangs on '{name}' itself")
        move_body(
            spec, name, model.body(holder).name, _place(model, index, note.get("ahead", 0.0)), free=False
        )
        spec.delete(next(text for text in spec.texts if text.name == element))
    return set(notes)


def _place(model: mujoco.MjModel, site: int, ahead: object) -> Pose:
    position, quat = tuple(model.site_pos[site].tolist()), tuple(model.site_quat[site].tolist())
    return add(position, rotate(quat, (0.0, 0.0, float(str(ahead))))), quat
