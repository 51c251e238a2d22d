"""deploy/: each file is checked by what can check it without a cluster."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
from processes import ROOT

from simx_client.cli.status import command as status
from simx_server.app import cli
from simx_server.settings.gathering import gather

DEPLOY = ROOT / "deploy"
MANIFESTS = sorted(path for path in (DEPLOY / "kubernetes").glob("*.yaml") if path.stem != "kustomization")
SLURM = DEPLOY / "slurm" / "fleet.sbatch"


def documents() -> list[dict[str, Any]]:
    yaml = pytest.importorskip("yaml", reason="PyYAML is not installed")
    return [document for path in MANIFESTS for document in yaml.safe_load_all(path.read_text())]


def resource(kind: str, name: str) -> dict[str, Any]:
    (found,) = [each for each in documents() if (each["kind"], each["metadata"]["name"]) == (kind, name)]
    return found


def test_manifests_fit_the_schemas_of_kubernetes() -> None:
    checker = pytest.importorskip("kubernetes_validate", reason="kubernetes-validate is not installed")
    checked = documents()
    assert len(checked) == 6
    for document in checked:
        checker.validate(document, "1.30", strict=True)
    wrong = resource("StatefulSet", "simx")
    wrong["spec"]["template"]["spec"]["containers"][0]["port"] = 1
    with pytest.raises(checker.ValidationError):
        checker.validate(wrong, "1.30", strict=True)


@pytest.mark.skipif(shutil.which("kubectl") is None, reason="kubectl is not installed")
def test_kubectl_composes_the_folder_and_replaces_the_image() -> None:
    done = subprocess.run(
        ["kubectl", "kustomize", DEPLOY / "kubernetes"], capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stderr
    assert "image: registry.example.org/simx:latest" in done.stdout
    assert done.stdout.count("\nkind: ") + done.stdout.startswith("kind: ") == 6


def test_the_servers_of_the_manifest_start_with_settings_that_there_are() -> None:
    pod = resource("StatefulSet", "simx")["spec"]["template"]["spec"]
    (container,) = pod["containers"]
    variables = {each["name"]: each.get("value", "simx-0") for each in container["env"]}
    flags = vars(cli.make_parser().parse_args(container["args"]))
    settings = gather({name: value for name, value in flags.items() if value}, variables)
    assert (settings.realm, settings.connect) == ("simx-0", ("tcp/simx-router:7447",))
    assert settings.scene == "ur5_rg2_kinect"
    for probe in ("startupProbe", "livenessProbe"):
        words = container[probe]["exec"]["command"]
        assert words[:4] == ["python", "-m", "simx_client", "status"]
        assert status.make_parser().parse_args(words[4:]).timeout < container[probe]["timeoutSeconds"]
    user = pod["securityContext"]["runAsUser"]
    assert f"--uid {user}" in (DEPLOY / "Containerfile").read_text()


def test_services_and_policies_of_the_manifest_select_the_pods() -> None:
    labels = [
        resource("StatefulSet", "simx")["spec"]["template"]["metadata"]["labels"],
        resource("Deployment", "simx-router")["spec"]["template"]["metadata"]["labels"],
    ]
    for name in ("simx", "simx-router"):
        assert resource("Service", name)["spec"]["selector"] in labels
        assert resource("NetworkPolicy", name)["spec"]["podSelector"]["matchLabels"] in labels
    assert resource("Service", "simx-router")["spec"]["ports"][0]["port"] == 7447


def test_the_container_file_is_that_of_the_page() -> None:
    page = (ROOT / "docs" / "operators" / "operations.md").read_text()
    (shown,) = re.findall(r"^```dockerfile Containerfile\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    assert (DEPLOY / "Containerfile").read_text() == shown


def stubs(folder: Path, address: str) -> Path:
    """Programs that write their names and arguments into the file ``calls``.

    Args:
        address: what the name of the first host means there.
    """
    for name in ("srun", "ray", "simx", "scontrol", "python3"):
        file = folder / name
        answer = {
            "srun": f'case "$*" in *--ip-address) echo {address};; *--all-ip-addresses) echo 10.1.0.1 10.2.0.1;; esac',
            "scontrol": "echo a; echo b",
            # As the fleet does, which waits for its hosts: the job starts them in the background.
            "simx": f'until [ "$(grep -c " start " "{folder}/calls")" -ge 2 ]; do sleep 0.01; done',
        }
        file.write_text(
            f'#!/bin/bash\necho {name} "$@" "[$SIMX_CONNECT]" >> "{folder}/calls"\n{answer.get(name, "")}\n'
        )
        file.chmod(0o755)
    return folder / "calls"


@pytest.mark.skipif(shutil.which("bash") is None, reason="bash is not installed")
@pytest.mark.parametrize("address", ["10.1.0.1 10.3.0.1", "127.0.1.1"])
def test_the_job_of_slurm_starts_ray_on_all_hosts_then_the_fleet_then_the_command(
    address: str, tmp_path: Path
) -> None:
    calls = stubs(tmp_path, address)
    job = {"SLURM_JOB_NODELIST": "x[1-2]", "SLURM_JOB_NUM_NODES": "2", "SLURM_JOB_ID": "12345"}
    done = subprocess.run(
        ["bash", SLURM, "python3", "train.py"],
        env={
            "PATH": f"{tmp_path}:{os.environ['PATH']}",
            "SLURM_CPUS_PER_TASK": "4",
            "SIMX_SCENE": "ur5",
            **job,
        },
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr
    made = calls.read_text().splitlines()
    started = sorted(line for line in made if " start " in line)
    assert len(started) == 2
    assert all("--cpus-per-task=4" in line for line in started)  # else one core for all servers of a host
    assert "--nodelist=a ray start --head --node-ip-address=10.1.0.1 --port=20345 --num-cpus=4" in started[0]
    assert "--nodelist=b ray start --address=10.1.0.1:20345 --num-cpus=4" in started[1]
    last = [line for line in made if line.startswith(("simx", "python3"))]
    assert last == [
        "simx fleet up ur5 --count 8 --ray 10.1.0.1:20345 --listen tcp/10.1.0.1:21345 []",
        "python3 train.py [tcp/10.1.0.1:21345]",
        "simx fleet down --ray 10.1.0.1:20345 []",
    ]


@pytest.mark.skipif(shutil.which("bash") is None, reason="bash is not installed")
def test_the_job_of_slurm_says_how_to_start_it() -> None:
    done = subprocess.run(
        ["bash", SLURM], env={"PATH": os.environ["PATH"]}, capture_output=True, text=True, timeout=60
    )
    assert done.returncode != 0
    assert "start this script with sbatch" in done.stderr
