"""Checks the choice of tokens and the rewriting on a small source."""

from mutation import draw, places, schemata

SOURCE = """#include "a.hpp"

namespace n {

constexpr int twice(int a) { return a + a; }

template <class S>
struct Point : Base<S> {
  double x[2] = {0, 1};
  Point(int n) : Base<S>(n - 1), k_{n + 1} { k_ -= n; }
  bool empty() const { return k_ == 0; }
};

const auto kNone = [] { return 1 - 1; }();

/// a + b
template <class T>
T sum(const Vector<T, 2 + 1>& a, int n) {
  static_assert(sizeof(T) < 9);
  T rows[6];
  T s = -a[0];
  for (int i = 0; i < n && n > 0; ++i) s += a[i] * (a[2] - n) + twice(n);
  if (n >= 3) throw Error(fmt::format("{}", n + 1));
  const auto f = [n](int j) { return "a + b" + name(j); };
  return s + a.template segment<3>(0).sum();
}

}  // namespace n
"""

EXPECTED = [
    ("sign", "k_ += n;"), ("term", "static_cast<void>(0);"),
    ("comparison", "k_ != 0;"),
    ("sign", "T s = a[0];"), ("index", "T s = -a[1];"),
    ("index", "int i = 1;"), ("comparison", "i <= n &&"), ("comparison", "i >= n &&"),
    ("comparison", "i < n || n"), ("comparison", "n >= 0;"), ("comparison", "n <= 0;"),
    ("sign", "s -= a[i]"), ("term", "++i) static_cast<void>(0);"), ("index", "a[i + 1] *"),
    ("index", "(a[3] - n)"), ("sign", "(a[2] + n)"), ("term", "(a[2] )"),
    ("sign", "- twice(n);"), ("term", "(a[2] - n) ;"),
    ("sign", "return s - a."), ("term", "return s ;"), ("index", "segment<3>(1)"),
]


def self_test(tree):
    """The faults found, as lines of text."""
    faults = []
    found = [(m.kind, m) for place in places.find_places(SOURCE) for m in place]
    if [kind for kind, _ in found] != [kind for kind, _ in EXPECTED]:
        faults.append("kinds of mutations: " + ", ".join(
            f"{m.kind} of '{SOURCE[m.start:m.end]}'" for _, m in found))
    for (_, mutation), (_, text) in zip(found, EXPECTED):
        if text not in mutation.apply(SOURCE):
            faults.append(f"'{text}' was expected, not '{mutation.replacement}' at {mutation.start}")

    mutants = [draw.make_mutant(n, "n", "src/n/a.cpp", SOURCE, mutation)
               for n, (_, mutation) in enumerate(found, 1)]
    text, lines = schemata.with_mutants(SOURCE, mutants)
    by_line = text.split("\n")
    for number, first, last in lines:
        part = "\n".join(by_line[first - 1:last])
        if number is not None and EXPECTED[number - 1][1] not in part:
            faults.append(f"mutant {number} is not on lines {first} to {last}")
    if text.count("constexpr int twice(int a) { return a + a; }") != 1:
        faults.append("what has no mutant is changed")

    if [m.mutation for m in draw.draw(tree, ["robot"], 1)] != [
            m.mutation for m in draw.draw(tree, ["robot"], 1)]:
        faults.append("a seed draws different mutants")
    return faults
