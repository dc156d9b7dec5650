"""Prints the rollouts a second of sampling starts beside MuJoCo's: see scripts/peers/rollout_rates.

usage: rollout_rates.py [--threads N]
"""

import argparse
import json
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

import mujoco
import numpy as np
from mujoco import rollout

from conddp_tool import BINARIES, ROOT
from machine import processor

SAMPLES, FEW, MANY, REPEATS = 128, 20, 220, 5
KNOTS, DT = 100, 0.03  # s
CASES = {"cart-pole": ("cartpole", "slider", "hinge"), "acrobot": ("acrobot", "elbow", "shoulder")}
RULES = {"rk4": mujoco.mjtIntegrator.mjINT_RK4, "semi_implicit_euler": mujoco.mjtIntegrator.mjINT_EULER}


def problem(urdf, motor, upright, rule):
    """A swing-up of the robot."""
    target = {"residual": "state", "reference": {"joints": {upright: np.pi}}}
    return {"conddp": 1, "name": "swing", "robot": {"urdf": str(urdf), "actuation": {"joints": [motor]}},
            "initial_state": {}, "integrator": rule, "phases": [{"name": "swing", "knots": KNOTS, "dt": DT}],
            "costs": {"effort": {"residual": "control", "weight": 0.02}, "state": {**target, "weight": 0.1}},
            "constraints": {"force": {"bounds": "control", "from": "urdf"}},
            "terminal": {"costs": {"upright": {**target, "weight": 200}}}}


def own_rate(document, threads):
    """Rollouts a second: the slope between runs with few and many rounds, without start and output of the program."""
    def seconds(folder, rounds):
        file = Path(folder) / "swing.yaml"
        guess = {"sampling": {"samples": SAMPLES, "rounds": rounds}}
        file.write_text(json.dumps({**document, "initial_guess": guess, "solver": {"threads": threads}}), encoding="utf-8")
        begin = time.perf_counter()
        subprocess.run([BINARIES / "conddp", "check", file], stdout=subprocess.DEVNULL, check=True)
        return time.perf_counter() - begin
    with tempfile.TemporaryDirectory() as folder:
        slopes = [SAMPLES * (MANY - FEW) / (seconds(folder, MANY) - seconds(folder, FEW)) for _ in range(REPEATS)]
    return statistics.median(slopes)


def mujoco_model(urdf, motor, rule):
    """The robot without contacts and stops, which the problem does not have either."""
    spec = mujoco.MjSpec.from_file(str(urdf))
    spec.add_actuator(name=motor, target=motor, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    spec.option.timestep = DT
    spec.option.integrator = RULES[rule]
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT | mujoco.mjtDisableBit.mjDSBL_CONTACT
    spec.compiler.boundinertia = 1e-9  # kg m²: MuJoCo takes no point masses
    return spec.compile()


def mujoco_rate(model, threads):
    """Rollouts a second of MuJoCo's own loop over steps in C, mujoco.rollout."""
    data = [mujoco.MjData(model) for _ in range(threads)]
    size = mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    begin = np.zeros(size)
    mujoco.mj_getState(model, data[0], begin, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    controls = np.random.default_rng(1).normal(size=(SAMPLES, KNOTS, model.nu))
    state = np.zeros((SAMPLES, KNOTS, size))
    sensors = np.zeros((SAMPLES, KNOTS, model.nsensordata))
    rates = []
    with rollout.Rollout(nthread=threads) as rolls:
        for _ in range(REPEATS):
            count = FEW
            start = time.perf_counter()
            for _ in range(count):
                rolls.rollout(model, data, begin[None], controls, state=state, sensordata=sensors, skip_checks=False)
            rates.append(count * SAMPLES / (time.perf_counter() - start))
    return statistics.median(rates)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--threads", type=int, nargs="*", default=[1, 2])
    wanted = parser.parse_args()
    print(f"{processor()}, {KNOTS} steps, {SAMPLES} rollouts at a time.\n")
    print(f"| robot | rule | threads | conddp, rollouts/s | MuJoCo {mujoco.__version__}, rollouts/s | ratio |\n"
          "|---|---|---|---|---|---|")
    for name, (robot, motor, upright) in CASES.items():
        urdf = ROOT / f"problems/robots/{robot}.urdf"
        for rule in RULES:
            model = mujoco_model(urdf, motor, rule)
            for threads in wanted.threads:
                own = own_rate(problem(urdf, motor, upright, rule), threads)
                theirs = mujoco_rate(model, threads)
                print(f"| {name} | `{rule}` | {threads} | {own:.0f} | {theirs:.0f} | {own / theirs:.2f} |", flush=True)


if __name__ == "__main__":
    main()
