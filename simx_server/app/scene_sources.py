"""The search folders of the scene that the settings name."""

from __future__ import annotations

from simx_server.files.library import DEFAULT_SCENE
from simx_server.files.robot_collections import xacro_arguments
from simx_server.scene.finding.scene_files import SceneFiles
from simx_server.scene.formats.sources import Sources
from simx_server.settings.settings import Settings


def sources_of(settings: Settings) -> Sources:
    """Return the sources for the files that a server reads; ``--xacro`` precedes the values of a collection.

    They know the files that clients have stored in the workspace, also for commands such as --convert.

    Raises:
        CommandError: the scene is in a collection, and cannot be had.
    """
    given = dict(text.split(":=", 1) for text in settings.xacro)
    sources = Sources.of(
        settings.package, xacro_arguments={**xacro_arguments(settings.scene or DEFAULT_SCENE), **given}
    )
    return SceneFiles(settings.workspace, sources).sources
