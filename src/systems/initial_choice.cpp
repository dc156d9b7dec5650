#include "systems/initial_choice.hpp"

#include "systems/closed_form.hpp"

namespace conddp {
namespace {

class InitialChoice : public ClosedFormSystem<InitialChoice> {
 public:
  InitialChoice(const System& of, std::vector<int> coordinates,
                const std::vector<std::string>& names)
      : ClosedFormSystem(SystemKind::first_order, of.manifold(),
                         static_cast<int>(coordinates.size())),
        coordinates_(std::move(coordinates)) {
    state_columns_ = of.state_columns();
    for (const std::string& name : names) control_columns_.push_back({name, ""});
  }

  template <class S>
  void rate(const S*, const S* u, S* f) const {
    for (int i = 0; i < ndx(); ++i) f[i] = S(0.0);
    for (int i = 0; i < nu(); ++i) f[coordinates_[i]] = u[i];
  }

 private:
  std::vector<int> coordinates_;
};

}  // namespace

std::shared_ptr<const System> initial_choice(const System& of, const std::vector<int>& coordinates,
                                             const std::vector<std::string>& names) {
  return std::make_shared<InitialChoice>(of, coordinates, names);
}

}  // namespace conddp
