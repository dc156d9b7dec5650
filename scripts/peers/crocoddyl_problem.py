"""A problem file, expanded, as Crocoddyl's shooting problem."""

import crocoddyl
import numpy as np
import pinocchio as pin

from references import pose, states, vector_values, weights_over_knots
from robot import Robot, components, require

AXES = {"world": pin.LOCAL_WORLD_ALIGNED, "local": pin.LOCAL}


class Translation:
    """Makes Crocoddyl's models of the phases of a problem."""

    def __init__(self, problem, drop=()):
        require(problem["integrator"] == "semi_implicit_euler",
                f"integrator: {problem['integrator']}")
        require(problem["running_costs"] == "rate", f"running_costs: {problem['running_costs']}")
        for phase in problem["phases"]:
            require("impulse" not in phase, f"phase '{phase['name']}': impulse")
        require(not problem["terminal"].get("constraints"), "terminal.constraints")
        self.problem = problem
        self.robot = Robot(problem)
        self.state = crocoddyl.StateMultibody(self.robot.model)
        actuation = (crocoddyl.ActuationModelFloatingBase if self.robot.floating
                     else crocoddyl.ActuationModelFull)
        self.actuation = actuation(self.state)
        self.weights = {name: weights_over_knots(problem, name) for name in problem["costs"]}
        self.constraints = {name: spec for name, spec in problem["constraints"].items()
                            if name not in drop}

    def shooting_problem(self):
        running, first = [], 0
        for phase in self.problem["phases"]:
            made = {}
            for k in range(first, first + phase["knots"]):
                terms = self.terms(self.problem["costs"], k, phase)
                key = tuple(term[3] for term in terms)
                if key not in made:  # knots that differ in nothing share a model
                    made[key] = self.knot(terms, phase)
                running.append(made[key])
            first += phase["knots"]
        terms = self.terms(self.problem["terminal"]["costs"], first, None)
        costs = crocoddyl.CostModelSum(self.state, self.actuation.nu)
        for name, cost, weight, _ in terms:
            costs.addCost(name, cost, weight)
        last = crocoddyl.IntegratedActionModelEuler(
            crocoddyl.DifferentialActionModelFreeFwdDynamics(self.state, self.actuation, costs), 0)
        shooting = crocoddyl.ShootingProblem(self.robot.initial, running, last)
        shooting.nthreads = 1  # its own default is fixed when it is built, whatever OpenMP is told
        return shooting

    def knot(self, terms, phase):
        costs = crocoddyl.CostModelSum(self.state, self.actuation.nu)
        for name, cost, weight, _ in terms:
            costs.addCost(name, cost, weight)
        if phase.get("contacts"):
            dynamics = crocoddyl.DifferentialActionModelContactFwdDynamics(
                self.state, self.actuation, self.contacts(phase["contacts"]), costs, 0.0, True)
        else:
            dynamics = crocoddyl.DifferentialActionModelFreeFwdDynamics(
                self.state, self.actuation, costs)
        knot = crocoddyl.IntegratedActionModelEuler(dynamics, phase["dt"])
        lower, upper = self.bounds(phase)
        if np.isfinite(lower).any() or np.isfinite(upper).any():
            knot.u_lb, knot.u_ub = lower, upper
        return knot

    def bounds(self, phase):
        names = self.robot.control_names()
        lower, upper = np.full(len(names), -np.inf), np.full(len(names), np.inf)
        for name, spec in self.constraints.items():
            require(spec.get("bounds") == "control",
                    f"constraint '{name}', which does not bound the controls")
            if phase["name"] not in spec.get("phases", [phase["name"]]):
                continue
            if spec.get("from") == "urdf":
                limit = self.robot.model.upperEffortLimit[-len(names):]
                lower, upper = np.maximum(lower, -limit), np.minimum(upper, limit)
            if "lower" in spec:
                lower = np.maximum(lower, components(spec["lower"], names, -np.inf))
            if "upper" in spec:
                upper = np.minimum(upper, components(spec["upper"], names, np.inf))
        return lower, upper

    def contacts(self, names):
        stack = crocoddyl.ContactModelMultiple(self.state, self.actuation.nu)
        for name in names:
            spec = self.problem["contacts"][name]
            require(spec["axes"] == "world", f"contact '{name}': axes {spec['axes']}")
            require(spec["type"] in ("point", "surface"), f"contact '{name}': type {spec['type']}")
            frame = self.robot.frame(spec["frame"])
            at = self.robot.placement(frame, self.robot.initial)
            if "placement" in spec:
                require(spec["baumgarte"]["kp"] == 0, f"contact '{name}': placement")
            gains = np.array([spec["baumgarte"]["kp"], spec["baumgarte"]["kd"]])
            point = spec["type"] == "point"
            make = crocoddyl.ContactModel3D if point else crocoddyl.ContactModel6D
            model = make(self.state, frame, at.translation if point else at,
                         self.force_axes(name), self.actuation.nu, gains)
            stack.addContact(name, model)
        return stack

    def force_axes(self, contact):
        """Friction cones are about the normal of the ground, wrench cones about that of the sole. The
        axes change nothing else where a contact holds the whole frame."""
        kinds = {cost["residual"] for cost in self.problem["costs"].values()
                 if contact in cost.get("contacts", ())}
        require(not {"friction_cone", "wrench_cone"} <= kinds, f"contact '{contact}': both cones")
        return pin.LOCAL if "wrench_cone" in kinds else pin.LOCAL_WORLD_ALIGNED

    def terms(self, costs, k, phase):
        """(name, cost model, weight, what tells it from that of other knots) of each cost that
        counts at node k; the terminal node has no phase."""
        terms = []
        for name, cost in costs.items():
            weight = cost["weight"] if phase is None else self.weights[name][k]
            if weight == 0:
                continue
            for label, activation, residual, key in self.residuals(name, cost, k, phase):
                args = (residual,) if activation is None else (activation, residual)
                model = crocoddyl.CostModelResidual(self.state, *args)
                terms.append((label, model, weight, (label, weight, key)))
        return terms

    def residuals(self, name, cost, k, phase):
        kind = cost["residual"]
        maker = getattr(self, "make_" + kind, None)
        require(maker is not None, f"cost '{name}': residual {kind}")
        if kind in ("friction_cone", "wrench_cone"):
            for contact in cost["contacts"]:
                if contact in phase["contacts"]:
                    yield maker(name, cost, contact)
            return
        residual, names, selected, key = maker(cost, k)
        weights = components(cost["weights"], names, 1.0)
        if selected is not None:
            weights = weights * selected
        yield name, self.activation(name, cost, weights, names), residual, key

    def activation(self, name, cost, weights, names):
        spec = cost["activation"]
        if spec == "quadratic":
            return None if (weights == 1).all() else crocoddyl.ActivationModelWeightedQuad(weights)
        require(spec["kind"] == "quadratic_barrier" and spec.get("from") is None
                and (weights == 1).all(), f"cost '{name}': activation {spec['kind']}")
        bounds = crocoddyl.ActivationBounds(
            components(spec.get("lower", {}), names, -np.inf),
            components(spec.get("upper", {}), names, np.inf))
        return crocoddyl.ActivationModelQuadraticBarrier(bounds)

    def make_friction_cone(self, name, cost, contact):
        spec = self.problem["contacts"][contact]
        require(cost["cone"] == "pyramid", f"cost '{name}': cone {cost['cone']}")
        require(spec["normal"] == [0, 0, 1], f"contact '{contact}': a normal that is not z")
        cone = crocoddyl.FrictionCone(
            np.eye(3), spec["friction"] * cost["safety"], cost["faces"], cost["inner"],
            spec["min_normal_force"], spec.get("max_normal_force", np.finfo(float).max))
        residual = crocoddyl.ResidualModelContactFrictionCone(
            self.state, self.robot.frame(spec["frame"]), cone, self.actuation.nu, True)
        require(cost["weights"] == 1, f"cost '{name}': weights of a cone")
        bounds = crocoddyl.ActivationBounds(cone.lb, cone.ub)
        return (f"{name} {contact}", crocoddyl.ActivationModelQuadraticBarrier(bounds), residual,
                contact)

    def make_wrench_cone(self, name, cost, contact):
        spec = self.problem["contacts"][contact]
        require(spec["normal"] == [0, 0, 1], f"contact '{contact}': a normal that is not z")
        cone = crocoddyl.WrenchCone(
            np.eye(3), spec["friction"] * cost["safety"], np.array(spec["size"]), 4, cost["inner"],
            spec["min_normal_force"], spec.get("max_normal_force", np.finfo(float).max))
        residual = crocoddyl.ResidualModelContactWrenchCone(
            self.state, self.robot.frame(spec["frame"]), cone, self.actuation.nu, True)
        require(cost["weights"] == 1, f"cost '{name}': weights of a cone")
        bounds = crocoddyl.ActivationBounds(cone.lb, cone.ub)
        return (f"{name} {contact}", crocoddyl.ActivationModelQuadraticBarrier(bounds), residual,
                contact)

    def make_state(self, cost, k):
        require("columns" not in cost, "columns of the residual state")
        reference = states(self.robot, self.problem, cost)(k)
        residual = crocoddyl.ResidualModelState(self.state, reference, self.actuation.nu)
        return residual, self.robot.state_names(), None, tuple(reference)

    def joint_part(self, cost, prefix):
        """A residual on some joints is one on the state with no weight on the others."""
        names = self.robot.state_names()
        selected = np.array([name in {f"{prefix}/{joint}" for joint in cost["joints"]}
                             for name in names], float)
        require(isinstance(cost["weights"], (int, float)), "weights by joint")
        reference = self.robot.state({})
        n = len(self.robot.joints)
        end = self.robot.model.nq if prefix == "q" else len(reference)
        require(isinstance(cost["reference"], (int, float)), "references by joint")
        reference[end - n:end] = cost["reference"]
        residual = crocoddyl.ResidualModelState(self.state, reference, self.actuation.nu)
        return residual, names, selected, None

    def make_joint_position(self, cost, k):
        return self.joint_part(cost, "q")

    def make_joint_velocity(self, cost, k):
        return self.joint_part(cost, "v")

    def make_control(self, cost, k):
        names = self.robot.control_names()
        require(isinstance(cost["reference"], (int, float, list)), "a control reference by name")
        reference = components(cost["reference"], names, 0.0)
        return crocoddyl.ResidualModelControl(self.state, reference), names, None, None

    def make_control_gravity(self, cost, k):
        residual = crocoddyl.ResidualModelControlGrav(self.state, self.actuation.nu)
        return residual, self.robot.control_names(), None, None

    def make_com_position(self, cost, k):
        at = vector_values(self.robot, self.problem, cost, self.robot.center_of_mass, np.array)(k)
        residual = crocoddyl.ResidualModelCoMPosition(self.state, at, self.actuation.nu)
        return residual, ["x", "y", "z"], None, tuple(at)

    def make_frame_position(self, cost, k):
        frame = self.robot.frame(cost["frame"])
        at = vector_values(self.robot, self.problem, cost,
                           lambda x: self.robot.placement(frame, x).translation, np.array)(k)
        residual = crocoddyl.ResidualModelFrameTranslation(self.state, frame, at,
                                                           self.actuation.nu)
        return residual, ["x", "y", "z"], None, tuple(at)

    def make_frame_placement(self, cost, k):
        at = pose(self.robot, self.problem, cost, k)
        residual = crocoddyl.ResidualModelFramePlacement(
            self.state, self.robot.frame(cost["frame"]), at, self.actuation.nu)
        return residual, ["x", "y", "z", "rx", "ry", "rz"], None, tuple(at.translation)

    def make_frame_rotation(self, cost, k):
        residual = crocoddyl.ResidualModelFrameRotation(
            self.state, self.robot.frame(cost["frame"]),
            pose(self.robot, self.problem, cost, k).rotation, self.actuation.nu)
        return residual, ["rx", "ry", "rz"], None, None

    def make_frame_velocity(self, cost, k):
        spec = cost["reference"]
        require("linear" in spec, "velocities that change over time")
        motion = pin.Motion(np.array(spec["linear"]), np.array(spec["angular"]))
        residual = crocoddyl.ResidualModelFrameVelocity(
            self.state, self.robot.frame(cost["frame"]), motion, AXES[cost["axes"]],
            self.actuation.nu)
        return residual, ["vx", "vy", "vz", "wx", "wy", "wz"], None, None
