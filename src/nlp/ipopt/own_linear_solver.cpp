#include "nlp/ipopt/own_linear_solver.hpp"

#include <algorithm>
#include <memory>
#include <vector>

#if __has_include(<HSLLoader.h>)
#include <HSLLoader.h>
#define CONDDP_HAS_HSL_LOADER 1
#else
#define CONDDP_HAS_HSL_LOADER 0
#endif

namespace conddp {

#if CONDDP_HAS_HSL_LOADER
namespace {

/// Indices in MA27's arrays of information (HSL: MA27, specification), from 0.
enum Information { kFlag = 0, kRealSize = 4, kIntegerSize = 5, kNegativeEigenvalues = 14 };
constexpr int kInformation = 20, kControls = 30, kTolerances = 5;
/// The matrix is singular.
constexpr int kSingular = -5;

MakeFactorization make_factorization = nullptr;
/// By number; Ipopt's integer arrays carry the number from one call to the next.
std::vector<std::unique_ptr<SymmetricFactorization>> factorizations;

SymmetricFactorization& numbered(const int* array) {
  return *factorizations.at(static_cast<std::size_t>(array[0]));
}

/// Ipopt counts from 1.
std::vector<int> from_zero(const int* indices, int count) {
  std::vector<int> shifted(indices, indices + count);
  for (int& index : shifted) --index;
  return shifted;
}

void set_defaults(int* controls, double* tolerances) {
  std::fill_n(controls, kControls, 0);
  std::fill_n(tolerances, kTolerances, 0.0);
}

void analyse(int* size, int* entries, const int* rows, const int* columns, int*, int*, int* keep,
             int*, int* steps, int*, int*, double*, int* info, double* operations) {
  keep[0] = static_cast<int>(factorizations.size());
  factorizations.push_back(make_factorization());
  factorizations.back()->analyse(*size, *entries, from_zero(rows, *entries).data(),
                                 from_zero(columns, *entries).data());
  std::fill_n(info, kInformation, 0);
  // Ipopt's arrays are unused, except for the number.
  info[kRealSize] = info[kIntegerSize] = 1;
  *steps = 1;
  *operations = 0;
}

void factorize(int*, int*, const int*, const int*, double* values, int*, int* factor, int*,
               int* keep, int*, int* front, int*, int*, double* tolerances, int* info) {
  SymmetricFactorization& factorization = numbered(keep);
  std::fill_n(info, kInformation, 0);
  factor[0] = keep[0];
  *front = 1;
  if (factorization.factorize(values, tolerances[0]) == SymmetricFactorization::Outcome::singular)
    info[kFlag] = kSingular;
  info[kNegativeEigenvalues] = factorization.negative_eigenvalues();
}

void solve(int*, double*, int*, int* factor, int*, double*, int*, double* b, int*, int*, int*,
           double*) {
  numbered(factor).solve(b);
}

}  // namespace

bool OwnLinearSolver::is_possible() { return true; }

OwnLinearSolver::OwnLinearSolver(MakeFactorization make) {
  make_factorization = make;
  LSL_setMA27(analyse, factorize, solve, set_defaults);
}

OwnLinearSolver::~OwnLinearSolver() {
  LSL_setMA27(nullptr, nullptr, nullptr, nullptr);
  factorizations.clear();
}

#else

bool OwnLinearSolver::is_possible() { return false; }
OwnLinearSolver::OwnLinearSolver(MakeFactorization) {}
OwnLinearSolver::~OwnLinearSolver() = default;

#endif

}  // namespace conddp
