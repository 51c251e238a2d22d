"""The files in memory of a scene and of all that it becomes, as MuJoCo reads them."""

from __future__ import annotations

import mujoco

_FULL = 0.8
"""Part of MuJoCo's store of processed files above which it is emptied: a full one takes no new files."""


class AssetFiles:
    """Compiles specs with the files in their `assets`, each of which is handed to MuJoCo once.

    MuJoCo computes a hash over all bytes of a file that it is given, which for the images of a scene takes longer than
    the rest of a compile. One thread at a time.
    """

    def __init__(self) -> None:
        self._files = mujoco.MjVfs()
        self._held: dict[str, bytes] = {}

    def compile(self, spec: mujoco.MjSpec) -> mujoco.MjModel:
        """Compile a spec. Raises as `MjSpec.compile`."""
        wanted: dict[str, bytes] = spec.assets  # the spec's own dictionary
        if not wanted:
            return spec.compile()
        self._hold(wanted)
        files = dict(wanted)
        wanted.clear()  # MuJoCo takes either
        try:
            return spec.compile(self._files)
        finally:
            wanted.update(files)

    def _hold(self, wanted: dict[str, bytes]) -> None:
        for name in [name for name, data in self._held.items() if wanted.get(name) is not data]:
            del self._files[name], self._held[name]
        for name in wanted.keys() - self._held.keys():
            self._files[name] = wanted[name]
            self._held[name] = wanted[name]


def make_room() -> None:
    """Empty MuJoCo's store of processed files if it is nearly full."""
    store = mujoco.mj_getCache()
    if mujoco.mj_getCacheSize(store) > _FULL * mujoco.mj_getCacheCapacity(store):
        mujoco.mj_clearCache(store)
