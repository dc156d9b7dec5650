"""The problems of scripts/peers/starts and the starts of each. Seeds are fixed."""

from dataclasses import dataclass

HYQ = "tests/foreign/hyq_trot.yaml"
ANYMAL = "tests/foreign/anymal_trot.yaml"
TALOS = "tests/foreign/talos_squat.yaml"
PANDA = "tests/foreign/panda_reach.yaml"
ARM = "problems/arm_reach.yaml"
QUADRUPED = "problems/quadruped_trot.yaml"
SQUAT = "problems/biped_squat.yaml"
STEPS = "problems/biped_steps.yaml"

#: Torques of the URDF, Nm, by names with patterns.
ARM_TORQUES = {"joint_1": 320, "joint_2": 320, "joint_3": 176, "joint_4": 176, "joint_5": 110,
               "joint_6": 40, "joint_7": 40}
PANDA_TORQUES = {**{f"panda_joint{i}": 87 for i in (1, 2, 3, 4)},
                 **{f"panda_joint{i}": 12 for i in (5, 6, 7)}}
QUADRUPED_TORQUES = {"*_HAA": 120, "*_HFE": 150, "*_KFE": 150}
#: Legs that are weaker than in the URDF and hold the robot in a squat.
WEAK_BIPED = {"*_hip_pitch": 30, "*_knee": 36, "*_ankle_pitch": 24}
WEAK_TALOS = {"leg_*": 48, "leg_*_4_joint": 90}

HYQ_SWINGS = {"swing_RF": 0, "swing_LH": 0, "swing_LF": 10, "swing_RH": 10}
#: ANYmal jumps instead: 0.25 s in the air without a contact. Touch-downs are no impulses.
JUMP = ("gait={type: jump, period: 0.5, duty: 0.5, dt: 0.02, step: {length: 0.2, height: 0.05}, "
        "stand: {begin: 0.3, end: 0.3}}",)
GUESSES = ("quasi_static", "zero")

#: (spread of the initial state, spread of the guess, number of seeds, how many of them in --quick)
EVERY = ((0, 0, 1, 1), (0.05, 0, 2, 0), (0.1, 0, 3, 1), (0.3, 0, 3, 1), (0.1, 0.1, 2, 0))
SOME = ((0, 0, 1, 0), (0.05, 0, 1, 0), (0.1, 0, 2, 1), (0.3, 0, 2, 1), (0.1, 0.1, 1, 0))
FEW = ((0, 0, 1, 0), (0.05, 0, 1, 0), (0.1, 0, 1, 1), (0.3, 0, 1, 0), (0.1, 0.1, 1, 0))


@dataclass(frozen=True)
class Instance:
    """One start of one problem."""
    row: str
    file: str
    settings: tuple
    state: float       # spread of the initial state
    guess: float       # spread of the guess
    seed: int
    controls: str      # initial_guess.controls
    quick: bool

    @property
    def overrides(self):
        return (*self.settings, f"initial_guess.controls={self.controls}")

    @property
    def perturbation(self):
        return (f"perturbation={{initial_state: {self.state:g}, guess: {self.guess:g}, "
                f"seed: {self.seed}}}")

    @property
    def name(self):
        return (f"{self.row}: {self.controls}, x0 ±{self.state:g}, guess {self.guess:g}, "
                f"seed {self.seed}")


def bounds(name, limits, percent=100):
    """A constraint that bounds controls by a share of their limits."""
    def values(sign):
        share = sign * percent / 100
        return ", ".join(f'"{joint}": {share * limit:g}' for joint, limit in limits.items())
    return (f"constraints.{name}={{bounds: control, lower: {{{values(-1)}}}, "
            f"upper: {{{values(1)}}}}}")


def hyq(percent, friction):
    return bounds("torque", {"*": 150}, percent), f"contacts.defaults.friction={friction}"


def finer_hyq(times):
    """Knots `times` as many and as short. Way-points of feet keep their moments; between them the
    references are on straight lines."""
    settings = []
    for p in (0, 1):
        settings += [f"phases.{p}.knots={10 * times}", f"phases.{p}.dt={0.02 / times:g}"]
    for swing, first in HYQ_SWINGS.items():
        knots = ", ".join(str(times * (first + k)) for k in range(10))
        settings.append(f"costs.{swing}.reference.knots=[{knots}]")
    return tuple(settings)


def rows():
    """(name, file, settings, starts) of every row."""
    for friction in (0.7, 0.15):
        for percent in (100, 60, 50, 40):
            yield (f"HyQ trot, {percent} % torque, friction {friction}", HYQ,
                   hyq(percent, friction), EVERY)
    for friction in (0.7, 0.15):
        for percent in (100, 40):
            yield (f"HyQ trot, dt/4, {percent} % torque, friction {friction}", HYQ,
                   (*hyq(percent, friction), *finer_hyq(4)), SOME if friction == 0.7 else FEW)
    for percent, starts in ((100, FEW), (60, SOME), (40, SOME)):
        yield (f"arm reach, {percent} % torque", ARM,
               (bounds("torque", ARM_TORQUES, percent),), starts)
    for percent in (100, 45):
        yield (f"Panda reach, {percent} % torque", PANDA,
               (bounds("torque", PANDA_TORQUES, percent),), SOME)
    for percent in (100, 30):
        yield (f"ANYmal trot, {percent} % torque", ANYMAL,
               (bounds("torque", {"*": 80}, percent),), SOME)
    for percent in (100, 50):
        yield (f"ANYmal jump, {percent} % torque", ANYMAL,
               (*JUMP, bounds("torque", {"*": 80}, percent)), SOME)
    for percent in (100, 30):
        yield (f"quadruped trot, {percent} % torque", QUADRUPED,
               (bounds("torque", QUADRUPED_TORQUES, percent),), SOME)
    yield "biped squat", SQUAT, (), FEW
    yield "biped squat, weak legs", SQUAT, (bounds("legs", WEAK_BIPED),), FEW
    yield "biped steps", STEPS, (), FEW
    yield "Talos squat", TALOS, (), FEW
    yield "Talos squat, weak legs", TALOS, (bounds("legs", WEAK_TALOS),), FEW


def instances():
    """All starts, row by row."""
    made = []
    for row, file, settings, starts in rows():
        for state, guess, seeds, quick in starts:
            for seed in range(1, seeds + 1):
                made += [Instance(row, file, settings, state, guess, seed, controls, seed <= quick)
                         for controls in GUESSES]
    return made
