#include "nlp/interior_point.hpp"

#include "nlp/ipopt_library.hpp"

namespace conddp {

InteriorPointAnswer minimise(NonlinearProgram& program, const Eigen::VectorXd& start,
                             const InteriorPointSettings& settings,
                             const std::function<bool(const InteriorPointIterate&)>& on_iterate) {
  return ipopt_library().minimise(program, start, settings, on_iterate);
}

}  // namespace conddp
