#pragma once

#include <array>
#include <complex>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "support/random_numbers.hpp"

namespace conddp {

/// A value with one derivative: an independent implementation of dual numbers for any scalar with
/// elementary functions.
template <class T>
struct Along {
  T value, slope;

  friend Along operator+(const Along& a, const Along& b) {
    return {a.value + b.value, a.slope + b.slope};
  }
  friend Along operator-(const Along& a, const Along& b) {
    return {a.value - b.value, a.slope - b.slope};
  }
  friend Along operator*(const Along& a, const Along& b) {
    return {a.value * b.value, a.slope * b.value + a.value * b.slope};
  }
  friend Along operator/(const Along& a, const Along& b) {
    return {a.value / b.value, (a.slope * b.value - a.value * b.slope) / (b.value * b.value)};
  }
};
template <class T>
Along<T> chain(const Along<T>& a, T value, T slope) {
  return {value, slope * a.slope};
}
template <class T>
Along<T> sin(const Along<T>& a) {
  return chain(a, sin(a.value), cos(a.value));
}
template <class T>
Along<T> cos(const Along<T>& a) {
  return chain(a, cos(a.value), -sin(a.value));
}
template <class T>
Along<T> tan(const Along<T>& a) {
  return chain(a, tan(a.value), T(1) / (cos(a.value) * cos(a.value)));
}
template <class T>
Along<T> asin(const Along<T>& a) {
  return chain(a, asin(a.value), T(1) / sqrt(T(1) - a.value * a.value));
}
template <class T>
Along<T> acos(const Along<T>& a) {
  return chain(a, acos(a.value), T(-1) / sqrt(T(1) - a.value * a.value));
}
template <class T>
Along<T> atan(const Along<T>& a) {
  return chain(a, atan(a.value), T(1) / (T(1) + a.value * a.value));
}
template <class T>
Along<T> sinh(const Along<T>& a) {
  return chain(a, sinh(a.value), cosh(a.value));
}
template <class T>
Along<T> cosh(const Along<T>& a) {
  return chain(a, cosh(a.value), sinh(a.value));
}
template <class T>
Along<T> tanh(const Along<T>& a) {
  return chain(a, tanh(a.value), T(1) / (cosh(a.value) * cosh(a.value)));
}
template <class T>
Along<T> exp(const Along<T>& a) {
  return chain(a, exp(a.value), exp(a.value));
}
template <class T>
Along<T> log(const Along<T>& a) {
  return chain(a, log(a.value), T(1) / a.value);
}
template <class T>
Along<T> sqrt(const Along<T>& a) {
  return chain(a, sqrt(a.value), T(0.5) / sqrt(a.value));
}

inline double real_part(const std::complex<double>& a) { return a.real(); }
template <class T>
double real_part(const Along<T>& a) {
  return real_part(a.value);
}

/// A random expression tree that prints itself as text and evaluates itself in any scalar with
/// complex parts. Its values and derivatives stay moderate: functions with a restricted domain get
/// arguments inside it.
class RandomExpression {
 public:
  RandomExpression(RandomNumbers& random, int inputs, int depth) {
    const int leaf = depth > 0 ? 0 : 1 + random.index(3);
    if (leaf == 1) {
      number_ = random.uniform(-2, 2);
      kind_ = Kind::kNumber;
    } else if (leaf > 1) {
      kind_ = Kind::kInput;
      index_ = random.index(inputs);
    } else {
      kind_ = static_cast<Kind>(2 + random.index(static_cast<int>(Kind::kCount) - 2));
      index_ = random.index(6) - 1;
      number_ = random.uniform(0.3, 1.5);
      const int operands = kind_ < Kind::kSin ? 2 : kind_ == Kind::kIf ? 3 : 1;
      for (int i = 0; i < operands; ++i) {
        const int shorter = 1 + random.index(2);
        operands_.emplace_back(random, inputs, std::max(0, depth - (i == 0 ? 1 : shorter)));
      }
    }
  }

  /// Inputs are named x0, x1, ...
  std::string text() const {
    const auto of = [&](int i) { return operands_[i].text(); };
    switch (kind_) {
      case Kind::kNumber:
        return number_ < 0 ? fmt::format("({})", number_) : fmt::format("{}", number_);
      case Kind::kInput:
        return fmt::format("x{}", index_);
      case Kind::kAdd:
        return fmt::format("({} + {})", of(0), of(1));
      case Kind::kSubtract:
        return fmt::format("({} - {})", of(0), of(1));
      case Kind::kMultiply:
        return fmt::format("{}*sin({})", of(0), of(1));
      case Kind::kDivide:
        return fmt::format("{}/(2 + cos({}))", of(0), of(1));
      case Kind::kAtan2:
        return fmt::format("atan2({}, 1.5 + sin({}))", of(0), of(1));
      case Kind::kHypot:
        return fmt::format("hypot(1 + ({})^2, {})", of(0), of(1));
      case Kind::kRealPower:
        return fmt::format("(1.5 + sin({}))^cos({})", of(0), of(1));
      case Kind::kSmoothMax:
        return fmt::format("smooth_max({}, {}, {})", of(0), of(1), number_);
      case Kind::kSin:
        return fmt::format("sin({})", of(0));
      case Kind::kCos:
        return fmt::format("cos({})", of(0));
      case Kind::kTan:
        return fmt::format("tan(0.7*sin({}))", of(0));
      case Kind::kAsin:
        return fmt::format("asin(0.8*sin({}))", of(0));
      case Kind::kAcos:
        return fmt::format("acos(0.8*sin({}))", of(0));
      case Kind::kAtan:
        return fmt::format("atan({})", of(0));
      case Kind::kSinh:
        return fmt::format("sinh(sin({}))", of(0));
      case Kind::kCosh:
        return fmt::format("cosh(sin({}))", of(0));
      case Kind::kTanh:
        return fmt::format("tanh({})", of(0));
      case Kind::kExp:
        return fmt::format("exp(sin({}))", of(0));
      case Kind::kLog:
        return fmt::format("log(1.2 + sin({}))", of(0));
      case Kind::kSqrt:
        return fmt::format("sqrt(1.2 + sin({}))", of(0));
      case Kind::kPower:
        return fmt::format("(0.5*cos({}) + {})^{}", of(0), number_, index_);
      case Kind::kConstantPower:
        return fmt::format("(1.2 + sin({}))^{}", of(0), number_);
      case Kind::kNegate:
        return fmt::format("-{}", of(0));
      case Kind::kSmoothAbs:
        return fmt::format("smooth_abs({}, {})", of(0), number_);
      case Kind::kIf:
        return fmt::format("if({} < 0.1, {}, {})", of(0), of(1), of(2));
      case Kind::kCount:
        break;
    }
    return "";
  }

  template <class T>
  T walk(const std::vector<T>& x) const {
    const auto constant = [](double a) { return scalar<T>(a); };
    const auto of = [&](int i) { return operands_[i].walk(x); };
    switch (kind_) {
      case Kind::kNumber:
        return constant(number_);
      case Kind::kInput:
        return x[index_];
      case Kind::kAdd:
        return of(0) + of(1);
      case Kind::kSubtract:
        return of(0) - of(1);
      case Kind::kMultiply:
        return of(0) * sin(of(1));
      case Kind::kDivide:
        return of(0) / (constant(2) + cos(of(1)));
      case Kind::kAtan2:  // x > 0
        return atan(of(0) / (constant(1.5) + sin(of(1))));
      case Kind::kHypot: {
        const T a = constant(1) + of(0) * of(0), b = of(1);
        return sqrt(a * a + b * b);
      }
      case Kind::kRealPower:
        return exp(cos(of(1)) * log(constant(1.5) + sin(of(0))));
      case Kind::kSmoothMax: {
        const T a = of(0), b = of(1);
        return constant(0.5) * (a + b + rounded(a - b));
      }
      case Kind::kSin:
        return sin(of(0));
      case Kind::kCos:
        return cos(of(0));
      case Kind::kTan:
        return tan(constant(0.7) * sin(of(0)));
      case Kind::kAsin:
        return asin(constant(0.8) * sin(of(0)));
      case Kind::kAcos:
        return acos(constant(0.8) * sin(of(0)));
      case Kind::kAtan:
        return atan(of(0));
      case Kind::kSinh:
        return sinh(sin(of(0)));
      case Kind::kCosh:
        return cosh(sin(of(0)));
      case Kind::kTanh:
        return tanh(of(0));
      case Kind::kExp:
        return exp(sin(of(0)));
      case Kind::kLog:
        return log(constant(1.2) + sin(of(0)));
      case Kind::kSqrt:
        return sqrt(constant(1.2) + sin(of(0)));
      case Kind::kPower: {
        const T base = constant(0.5) * cos(of(0)) + constant(number_);
        T result = constant(1);
        for (int i = 0; i < std::abs(index_); ++i) result = result * base;
        return index_ < 0 ? constant(1) / result : result;
      }
      case Kind::kConstantPower:
        return exp(constant(number_) * log(constant(1.2) + sin(of(0))));
      case Kind::kNegate:
        return constant(0) - of(0);
      case Kind::kSmoothAbs:
        return rounded(of(0));
      case Kind::kIf:
        return real_part(of(0)) < 0.1 ? of(1) : of(2);
      case Kind::kCount:
        break;
    }
    return constant(0);
  }

 private:
  enum class Kind {
    kNumber,
    kInput,
    kAdd,
    kSubtract,
    kMultiply,
    kDivide,
    kAtan2,
    kHypot,
    kRealPower,
    kSmoothMax,
    kSin,
    kCos,
    kTan,
    kAsin,
    kAcos,
    kAtan,
    kSinh,
    kCosh,
    kTanh,
    kExp,
    kLog,
    kSqrt,
    kPower,
    kConstantPower,
    kNegate,
    kSmoothAbs,
    kIf,
    kCount
  };
  template <class T>
  static T scalar(double a) {
    if constexpr (std::is_same_v<T, std::complex<double>>)
      return T(a);
    else
      return T{a, 0};
  }
  template <class T>
  T rounded(const T& a) const {
    return sqrt(a * a + scalar<T>(number_ * number_));
  }

  Kind kind_ = Kind::kNumber;
  double number_ = 0;
  int index_ = 0;
  std::vector<RandomExpression> operands_;
};

}  // namespace conddp
