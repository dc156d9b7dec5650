#include "batch/plan/sobol.hpp"

#include <array>
#include <bit>
#include <random>

namespace conddp {
namespace {

constexpr int kDigits = 32;

/// A primitive polynomial over the integers modulo 2 and its first direction numbers.
struct Polynomial {
  int degree;
  std::uint32_t coefficients;  ///< without the first and the last, which are 1
  std::array<std::uint32_t, 6> first;
};

constexpr Polynomial kPolynomials[kSobolDimensions - 1] = {
    {1, 0, {1}},
    {2, 1, {1, 3}},
    {3, 1, {1, 3, 1}},
    {3, 2, {1, 1, 1}},
    {4, 1, {1, 1, 3, 3}},
    {4, 4, {1, 3, 5, 13}},
    {5, 2, {1, 1, 5, 5, 17}},
    {5, 4, {1, 1, 5, 5, 5}},
    {5, 7, {1, 1, 7, 11, 19}},
    {5, 11, {1, 1, 5, 1, 1}},
    {5, 13, {1, 1, 1, 3, 11}},
    {5, 14, {1, 3, 5, 5, 31}},
    {6, 1, {1, 3, 3, 9, 7, 49}},
    {6, 13, {1, 1, 1, 15, 21, 21}},
    {6, 16, {1, 3, 1, 13, 27, 49}},
};

/// The direction numbers of one coordinate; the first binary digit after the point is the highest
/// bit.
std::vector<std::uint32_t> direction_numbers(int coordinate) {
  std::vector<std::uint32_t> v(kDigits);
  if (coordinate == 0) {
    for (int i = 0; i < kDigits; ++i) v[i] = 1u << (kDigits - 1 - i);
    return v;
  }
  const Polynomial& p = kPolynomials[coordinate - 1];
  for (int i = 0; i < p.degree; ++i) v[i] = p.first[i] << (kDigits - 1 - i);
  for (int i = p.degree; i < kDigits; ++i) {
    v[i] = v[i - p.degree] ^ (v[i - p.degree] >> p.degree);
    for (int k = 1; k < p.degree; ++k)
      if ((p.coefficients >> (p.degree - 1 - k)) & 1u) v[i] ^= v[i - k];
  }
  return v;
}

}  // namespace

SobolSequence::SobolSequence(int dimensions, std::uint64_t seed) : point_(dimensions) {
  for (int i = 0; i < dimensions; ++i) directions_.push_back(direction_numbers(i));
  if (seed == 0) return;
  std::mt19937_64 engine(seed);
  for (std::uint32_t& digits : point_) digits = static_cast<std::uint32_t>(engine() >> 32);
}

std::vector<double> SobolSequence::next() {
  std::vector<double> point;
  for (const std::uint32_t digits : point_) point.push_back(digits * 0x1p-32);
  // Points are in Gray code order: the next one differs in the direction of the lowest zero bit of
  // the count.
  const int digit = std::countr_one(count_++);
  for (std::size_t i = 0; i < point_.size(); ++i) point_[i] ^= directions_[i][digit % kDigits];
  return point;
}

}  // namespace conddp
