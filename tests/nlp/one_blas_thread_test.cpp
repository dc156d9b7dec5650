#include <dlfcn.h>

#include <gtest/gtest.h>

#include "nlp/interior_point.hpp"

namespace conddp {
namespace {

/// Minimizes ½ y² subject to y ≥ 1.
class OneBound : public NonlinearProgram {
 public:
  OneBound() {
    lower_ = Eigen::VectorXd::Ones(1);
    upper_ = Eigen::VectorXd::Constant(1, 5);
    row_lower_ = row_upper_ = Eigen::VectorXd(0);
    hessian_.add(0, 0);
  }
  void set_point(const double* y) override { y_ = y[0]; }
  double objective() override { return y_ * y_ / 2; }
  void gradient(double* out) override { out[0] = y_; }
  void constraints(double*) override {}
  void jacobian(double*) override {}
  void hessian(double weight, const double*, double* out) override { out[0] = weight; }

 private:
  double y_ = 0;
};

/// A function of the loaded OpenBLAS; null for another BLAS.
template <class Function>
Function* openblas_function(const char* name) {
  void* const library = dlopen("libopenblas.so.0", RTLD_LAZY | RTLD_NOLOAD);
  return library == nullptr ? nullptr : reinterpret_cast<Function*>(dlsym(library, name));
}

TEST(OneBlasThread, LimitsOpenBlasToOneThreadDuringSolves) {
  OneBound program;
  const Eigen::VectorXd start = Eigen::VectorXd::Constant(1, 3);
  const auto go_on = [](const InteriorPointIterate&) { return true; };
  EXPECT_EQ(minimise(program, start, {}, go_on).end, InteriorPointEnd::solved);
  const auto threads = openblas_function<int()>("openblas_get_num_threads");
  if (threads == nullptr) GTEST_SKIP() << "the system's BLAS is another one";
  openblas_function<void(int)>("openblas_set_num_threads")(2);
  const int before = threads();  // 1 if this OpenBLAS is single-threaded
  minimise(program, start, {}, [&](const InteriorPointIterate&) {
    EXPECT_EQ(threads(), 1);
    return true;
  });
  EXPECT_EQ(threads(), before);
}

}  // namespace
}  // namespace conddp
