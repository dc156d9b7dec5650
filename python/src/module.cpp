// The Python module conddp._core: problems, answers and controllers in memory. The package around it
// (conddp/__init__.py) has the names and documents that users see.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "answer.hpp"
#include "loop.hpp"
#include "problem.hpp"

namespace py = pybind11;
using namespace conddp::python;

namespace {

/// Raises conddp.ProblemError with the text of all errors and each of them as a dictionary.
void raise(const conddp::ProblemFailure& failure) {
  py::list entries;
  for (const conddp::Diagnostic& d : failure.errors) {
    py::dict entry;
    entry["message"] = d.message;
    entry["hint"] = d.hint;
    entry["key"] = d.path;
    entry["file"] = d.file;
    entry["line"] = d.line;
    entry["column"] = d.column;
    entry["accepted"] = d.accepted;
    entries.append(entry);
  }
  const py::object type = py::module_::import("conddp._errors").attr("ProblemError");
  PyErr_SetObject(type.ptr(), type(failure.text, entries).ptr());
}

/// An array that shows numbers of an answer, which it keeps alive.
py::array shown(const double* data, std::vector<py::ssize_t> shape,
                std::vector<py::ssize_t> strides, const py::object& owner) {
  py::array_t<double> array(std::move(shape), std::move(strides), data, owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

constexpr py::ssize_t kNumber = sizeof(double);

py::array states(const py::object& self) {
  const conddp::Trajectory& motion = self.cast<const Answer&>().result.trajectory;
  return shown(motion.x(0).data(), {motion.knots() + 1, motion.nx()},
               {motion.nx() * kNumber, kNumber}, self);
}

/// One array if all knots have equally many controls, else one for each knot.
py::object controls(const py::object& self) {
  const conddp::Trajectory& motion = self.cast<const Answer&>().result.trajectory;
  bool equal = motion.knots() > 0;
  for (int k = 1; k < motion.knots(); ++k) equal = equal && motion.nu(k) == motion.nu(0);
  if (equal)
    return shown(motion.u(0).data(), {motion.knots(), motion.nu(0)},
                 {motion.nu(0) * kNumber, kNumber}, self);
  py::list list;
  for (int k = 0; k < motion.knots(); ++k)
    list.append(shown(motion.u(k).data(), {motion.nu(k)}, {kNumber}, self));
  return list;
}

py::list gains(const py::object& self) {
  py::list list;
  for (const Eigen::MatrixXd& K : self.cast<const Answer&>().result.feedback.K)
    list.append(shown(K.data(), {K.rows(), K.cols()}, {kNumber, K.rows() * kNumber}, self));
  return list;
}

}  // namespace

PYBIND11_MODULE(_core, m) {
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const conddp::ProblemFailure& failure) {
      raise(failure);
    }
  });

  py::class_<Answer, std::shared_ptr<Answer>>(m, "Answer")
      .def_property_readonly("status", &Answer::status)
      .def_property_readonly("solved", &Answer::solved)
      .def_property_readonly("solver", &Answer::solver_name)
      .def_property_readonly("verdict", &Answer::verdict)
      .def_property_readonly("message", [](const Answer& a) { return a.result.message; })
      .def_property_readonly("cost", [](const Answer& a) { return a.result.cost; })
      .def_property_readonly("iterations", [](const Answer& a) { return a.result.iterations; })
      .def_property_readonly("seconds", [](const Answer& a) { return a.result.times.total; })
      .def_property_readonly("t", [](const Answer& a) { return py::array(py::cast(a.times())); })
      .def_property_readonly("x", &states)
      .def_property_readonly("u", &controls)
      .def_property_readonly("K", &gains)
      .def("names", &Answer::names)
      .def("document", &Answer::document_text, py::call_guard<py::gil_scoped_release>())
      .def("certificate", &Answer::certificate_text)
      .def("page", &Answer::page, py::call_guard<py::gil_scoped_release>())
      .def("write", &Answer::write, py::call_guard<py::gil_scoped_release>());

  py::class_<Problem>(m, "Problem")
      .def(py::init(&Problem::load))
      .def(py::init(&Problem::parse))
      .def("set", &Problem::set)
      .def("get", &Problem::get)
      .def("check", &Problem::check, py::call_guard<py::gil_scoped_release>())
      .def("copy", [](const Problem& problem) { return Problem(problem); })
      .def("describe", &Problem::describe, py::call_guard<py::gil_scoped_release>())
      .def("solve", &Problem::solve)
      .def("solve_many", &Problem::solve_many);

  py::class_<Loop>(m, "Loop")
      .def(py::init<const Problem&>())
      .def("tick", &Loop::tick)
      .def("prepare", &Loop::prepare)
      .def_property_readonly("period", &Loop::period)
      .def_property_readonly("last", &Loop::last_tick);
}
