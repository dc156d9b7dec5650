#include "output/scene/scene_numbers.hpp"

#include <cmath>

namespace conddp {
namespace {

double micrometres(double x) {
  if (!std::isfinite(x)) return x;
  const double rounded = std::round(x * 1e6) / 1e6;
  return rounded == 0 ? 0 : rounded;  // avoids −0
}

}  // namespace

void append(OrderedJson& list, const Vector3<double>& v) {
  for (const double x : {v.x, v.y, v.z}) list.push_back(finite_or_null(micrometres(x)));
}

void append(OrderedJson& list, const SE3<double>& placement) {
  append(list, placement.p);
  const Quaternion<double> q = quaternion(placement.R);
  for (const double x : {q.x, q.y, q.z, q.w}) list.push_back(finite_or_null(micrometres(x)));
}

OrderedJson vector_json(const Vector3<double>& v) {
  OrderedJson list = OrderedJson::array();
  append(list, v);
  return list;
}

OrderedJson placement_json(const SE3<double>& placement) {
  OrderedJson list = OrderedJson::array();
  append(list, placement);
  return list;
}

}  // namespace conddp
