"""Open a scene, add a model to it: shipped ones by name, others by their path in the server's workspace. Save it."""

from __future__ import annotations

import msgpack
import viser

import simx_client as simx
from simx_client import Client
from simx_client.protocol.add_ons.past import ADD_ON, ADD_ON_TYPE
from simx_server.viewer.messages import FILES, SAVE, Look, Saved, Survey
from simx_server.viewer.messages import Files as Names
from simx_server.viewer.page.link import Hands

_OWN: str = "(a file of the workspace)"


class Files:
    """The folder. The server decides which files may be loaded, as for every client."""

    def __init__(self, gui: viser.GuiApi, hands: Hands) -> None:
        self._hands = hands
        self._is_asked = False
        self._names: Names | None = None
        self._scene_name = "scene"
        with gui.add_folder("Open or save a scene", expand_by_default=False):
            self._scene: viser.GuiDropdownHandle[str] = gui.add_dropdown(
                "Scene", (_OWN,), hint="shipped scenes"
            )
            self._model: viser.GuiDropdownHandle[str] = gui.add_dropdown(
                "Model", (_OWN,), hint="shipped models"
            )
            self._path = gui.add_text(
                "File", "", hint="a path in the server's workspace, for the entries (a file ...)"
            )
            opens = gui.add_button(
                "Open scene",
                icon=viser.Icon.FOLDER_OPEN,
                hint="in place of the present one; stop the simulation first",
            )
            adds = gui.add_button("Add model", icon=viser.Icon.CUBE_PLUS, hint="to the present scene")
            saves = gui.add_button(
                "Save scene",
                icon=viser.Icon.DEVICE_FLOPPY,
                hint="as the file above in the server's workspace: .mjz, .xml, or .ttt for a scene of V-REP",
            )
            downloads = gui.add_button(
                "Download scene",
                icon=viser.Icon.DOWNLOAD,
                hint="as MuJoCo's archive, .mjz; the browser saves it",
            )
        saves.on_click(lambda _: self._save())
        downloads.on_click(lambda event: self._download(event.client))
        opens.on_click(lambda _: self._open(self._scene.value, is_model=False))
        adds.on_click(lambda _: self._open(self._model.value, is_model=True))

    def update(self, survey: Survey, look: Look) -> None:
        """Offer the shipped files, once the server has named them."""
        if not self._is_asked:
            self._is_asked = True
            self._hands.do(self._ask)
        self._scene_name = look["scene"]
        names, self._names = self._names, None
        if names is not None:
            self._scene.options = (_OWN, *names["scenes"])
            self._model.options = (_OWN, *names["models"])

    def close(self) -> None:
        """Do nothing."""

    def _ask(self, client: Client) -> None:
        answer = client.call(FILES, ADD_ON, script_type=ADD_ON_TYPE)
        self._names = msgpack.unpackb(answer.buffer)

    def _open(self, chosen: str, *, is_model: bool) -> None:
        """Load the chosen file. A thread of viser's."""
        name = self._path.value.strip() if chosen == _OWN else chosen
        self._hands.do(lambda client: load(client, name, is_model=is_model))

    def _save(self) -> None:
        """Save the scene in the workspace. A thread of viser's."""
        name = self._path.value.strip()
        self._hands.do(lambda client: save(client, name))

    def _download(self, browser: viser.ClientHandle | None) -> None:
        """Send the scene to a browser. A thread of viser's."""
        if browser is not None:
            self._hands.do(lambda client: send(client, browser, self._scene_name))


def save(client: Client, name: str) -> None:
    """Save the scene as a file of the workspace. Raises ValueError: no name was given; SimxError: it is refused."""
    if not name:
        raise ValueError("no file is named; type a path in the server's workspace, such as scene.mjz")
    client.call(SAVE, ADD_ON, script_type=ADD_ON_TYPE, strings=[name])


def send(client: Client, browser: viser.ClientHandle, name: str) -> None:
    """Let a browser download the scene. Raises SimxError: it cannot be saved."""
    answer: Saved = msgpack.unpackb(client.call(SAVE, ADD_ON, script_type=ADD_ON_TYPE, strings=[""]).buffer)
    browser.send_file_download(f"{name}.mjz", answer["content"], save_immediately=True)


def load(client: Client, name: str, *, is_model: bool) -> None:
    """Load a scene or a model. Raises ValueError: no name was given, or the server refuses it, with its reason."""
    if not name:
        raise ValueError("no file is named; choose a shipped one, or type a path in the server's workspace")
    function = "simxLoadModel" if is_model else "simxLoadScene"
    if is_model:
        code = simx.simxLoadModel(client.id, name, 0, simx.simx_opmode_blocking)[0]
    else:
        code = simx.simxLoadScene(client.id, name, 0, simx.simx_opmode_blocking)
    if code != simx.simx_return_ok:
        errors = simx.simxGetLastErrors(client.id, simx.simx_opmode_blocking)[1]
        reasons = [error for error in errors if error.startswith(function)]  # others may be of scripts
        raise ValueError(
            reasons[-1] if reasons else f"'{name}' could not be loaded; the server's log has the reason"
        )
