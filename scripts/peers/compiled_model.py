"""The model of docs/problem_file.md by CasADi beside the same model in expressions."""

import json
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
CONDDP = ROOT / "build" / "release" / "bin" / "conddp"
TOLERANCE = 1e-9

SYSTEMS = {
    "casadi": "library: model.so\n  function: f",
    "expressions": "rate: {theta: omega, omega: (torque - m*9.81*l*sin(theta))/(m*l^2)}",
}
PROBLEM = """conddp: 1
system:
  {system}
  states: {{theta: rad, omega: rad/s}}
  controls: {{torque: Nm}}
  parameters: {{m: 1, l: 0.5}}
initial_state: {{}}
integrator: rk4
phases: [{{knots: 100, dt: 0.02}}]
costs: {{effort: {{residual: control, weight: 0.1}}}}
constraints: {{torque: {{bounds: control, lower: -3, upper: 3}}}}
terminal: {{costs: {{goal: {{residual: state, reference: [3.14159, 0], weight: 100}}}}}}
solver: {{name: {solver}, tolerances: {{stationarity: 1.0e-9}}}}
"""


def script_of_documents():
    text = (ROOT / "docs" / "problem_file.md").read_text(encoding="utf-8")
    return re.search(r"```python\n(.*?)```", text, re.S).group(1)


def cost_of(folder, name, solver):
    file = folder / f"{name}.yaml"
    file.write_text(PROBLEM.format(system=SYSTEMS[name], solver=solver), encoding="utf-8")
    command = [CONDDP, "solve", file, "--json", "--allow-code", "-o", folder / name]
    run = subprocess.run(command, capture_output=True, check=True, text=True)
    head = json.loads(run.stdout)
    if head["status"] != "converged":
        raise SystemExit(f"{name} by {solver}: {head['status']}")
    subprocess.run(
        [CONDDP, "verify", folder / name / "solution.json", "--allow-code", "--quiet"], check=True
    )
    return head["cost"]


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "model.py").write_text(script_of_documents(), encoding="utf-8")
        subprocess.run([sys.executable, "model.py"], cwd=folder, check=True)
        compile_it = ["cc", "-O2", "-shared", "-fPIC", "model.c", "-o", "model.so", "-lm"]
        subprocess.run(compile_it, cwd=folder, check=True)
        worst = 0
        for solver in ("box_fddp", "box_ddp", "altro", "ipopt"):
            compiled, words = (cost_of(folder, name, solver) for name in ("casadi", "expressions"))
            difference = abs(compiled - words) / abs(words)
            worst = max(worst, difference)
            print(f"{solver}: {compiled:.12g} by CasADi, {words:.12g} in words, {difference:.1e} apart")
    return 0 if worst <= TOLERANCE else 1


if __name__ == "__main__":
    sys.exit(main())
