#include "output/solution/npz.hpp"

#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include <zlib.h>

#include <fmt/format.h>

#include "base/text/utf8.hpp"
#include "ocp/problem/by_name.hpp"

namespace conddp {
namespace {

using Shape = std::vector<std::size_t>;

void append(std::string& bytes, std::uint64_t number, int count) {
  for (int i = 0; i < count; ++i) bytes.push_back(static_cast<char>(number >> (8 * i)));
}

/// A file of NumPy's format 1.0, in C order: a header, padded so that the data begins at a multiple
/// of 64 bytes, and the data.
std::string npy(std::string_view type, const Shape& shape, std::string_view data) {
  std::string sizes;
  for (const std::size_t size : shape) sizes += fmt::format("{},", size);
  std::string header =
      fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}", type, sizes);
  constexpr std::size_t kBefore = 10, kAlignment = 64;
  header.append(kAlignment - (kBefore + header.size() + 1) % kAlignment, ' ');
  header += '\n';
  std::string file("\x93NUMPY\x01\x00", 8);
  append(file, header.size(), 2);
  return file.append(header).append(data);
}

/// An archive of uncompressed files (ZIP, as in PKWARE's APPNOTE 4.3.7 and 4.3.12).
class Zip {
 public:
  void add(const std::string& name, const std::string& content) {
    const std::string entry = description(content, name.size());
    const std::size_t start = bytes_.size();
    append(bytes_, 0x04034b50, 4);
    bytes_ += entry;
    bytes_ += name;
    bytes_ += content;
    append(directory_, 0x02014b50, 4);
    append(directory_, 20, 2);  // made by version 2.0
    directory_ += entry;
    append(directory_, 0, 10);  // no comment, first disk, no attributes
    append(directory_, start, 4);
    directory_ += name;
    ++count_;
  }

  std::string finish() && {
    const std::size_t start = bytes_.size();
    bytes_ += directory_;
    append(bytes_, 0x06054b50, 4);
    append(bytes_, 0, 4);  // one disk
    append(bytes_, count_, 2);
    append(bytes_, count_, 2);
    append(bytes_, directory_.size(), 4);
    append(bytes_, start, 4);
    append(bytes_, 0, 2);
    return std::move(bytes_);
  }

 private:
  /// The fields that a file and its entry in the directory have in common.
  static std::string description(const std::string& content, std::size_t name_length) {
    constexpr std::uint64_t kDate =
        (0 << 9) | (1 << 5) | 1;  // 1980-01-01: equal answers, equal files
    const auto sum = crc32_z(0, reinterpret_cast<const Bytef*>(content.data()), content.size());
    std::string entry;
    append(entry, 20, 2);  // needs version 2.0
    append(entry, 0, 4);   // no flags, stored
    append(entry, kDate << 16, 4);
    append(entry, sum, 4);
    append(entry, content.size(), 4);
    append(entry, content.size(), 4);
    append(entry, name_length, 2);
    append(entry, 0, 2);
    return entry;
  }

  std::string bytes_, directory_;
  std::size_t count_ = 0;
};

class Archive {
 public:
  void add(const std::string& name, const Shape& shape, std::span<const double> values) {
    const std::string_view data(reinterpret_cast<const char*>(values.data()), values.size_bytes());
    zip_.add(name + ".npy", npy("<f8", shape, data));
  }
  void add(const std::string& name, const std::vector<std::string>& texts) {
    int longest = 1;
    for (const std::string& text : texts) longest = std::max(longest, count_characters(text));
    std::string data;
    for (const std::string& text : texts) {
      const std::u32string characters = code_points(text);
      for (const char32_t c : characters) append(data, c, 4);
      append(data, 0, 4 * (longest - static_cast<int>(characters.size())));
    }
    zip_.add(name + ".npy", npy(fmt::format("<U{}", longest), {texts.size()}, data));
  }
  std::string finish() && { return std::move(zip_).finish(); }

 private:
  static std::u32string code_points(std::string_view text) {
    std::u32string points;
    for (const char c : text) {
      const auto byte = static_cast<unsigned char>(c);
      if (!starts_character(c) && !points.empty())
        points.back() = points.back() << 6 | (byte & 0x3f);
      else
        points.push_back(byte < 0x80 ? byte : byte & (byte < 0xe0 ? 0x1f : byte < 0xf0 ? 0x0f : 7));
    }
    return points;
  }

  Zip zip_;
};

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

std::size_t size(Eigen::Index count) { return static_cast<std::size_t>(count); }

void add_motion(const Solution& s, Archive& archive) {
  const ShootingProblem& problem = *s.built.problem;
  const int N = problem.knots(), nu = ControlColumns(problem).count(), ndx = problem.ndx();
  const ControlColumns columns(problem);
  const double none = std::numeric_limits<double>::quiet_NaN();
  const auto table = [&](const std::string& name, const auto& own) {
    RowMajor rows = RowMajor::Constant(N, nu, none);
    for (int k = 0; k < N; ++k)
      if (const Eigen::VectorXd row = columns.row(k, own(k)); row.size() == nu) rows.row(k) = row;
    archive.add(name, {size(N), size(nu)}, {rows.data(), size(rows.size())});
  };
  const Trajectory& motion = s.result.trajectory;
  archive.add("t", {size(N + 1)}, problem.times(motion));
  RowMajor states(N + 1, problem.nx());
  for (int k = 0; k <= N; ++k) states.row(k) = motion.x(k);
  archive.add("x", {size(N + 1), size(problem.nx())}, {states.data(), size(states.size())});
  table("u", [&](int k) -> Eigen::VectorXd { return motion.u(k); });
  table("k", [&](int k) -> Eigen::VectorXd { return s.result.feedback.k[k]; });
  RowMajor gains = RowMajor::Constant(N * nu, ndx, none);
  for (int k = 0; k < N; ++k)
    if (const Eigen::MatrixXd own = columns.rows(k, s.result.feedback.K[k]); own.rows() == nu)
      gains.middleRows(k * nu, nu) = own;
  archive.add("K", {size(N), size(nu), size(ndx)}, {gains.data(), size(gains.size())});
  const Eigen::MatrixXd& costates = s.result.costates;
  archive.add("costates", {size(costates.cols()), size(costates.rows())},
              {costates.data(), size(costates.size())});
}

void add_forces(const ContactForces& forces, int knots, Archive& archive) {
  for (const auto& contact : forces.contacts) {
    RowMajor rows = RowMajor::Constant(knots, 6, std::numeric_limits<double>::quiet_NaN());
    for (int k = 0; k < knots; ++k)
      if (const auto& wrench = contact.wrench[size(k)])
        rows.row(k) = Eigen::Map<const Eigen::RowVectorXd>(wrench->data(), 6);
    archive.add("contact/" + contact.name, {size(knots), 6}, {rows.data(), size(rows.size())});
  }
}

}  // namespace

std::string solution_npz(const Solution& s) {
  Archive archive;
  add_motion(s, archive);
  add_forces(s.answer.forces, s.built.problem->knots(), archive);
  const auto add_names = [&](const std::string& name, const std::vector<Column>& columns,
                             std::string Column::*member) {
    std::vector<std::string> texts;
    for (const Column& column : columns) texts.push_back(column.*member);
    archive.add(name, texts);
  };
  add_names("x_names", s.built.state_columns, &Column::name);
  add_names("u_names", s.built.control_columns, &Column::name);
  add_names("x_units", s.built.state_columns, &Column::unit);
  add_names("u_units", s.built.control_columns, &Column::unit);
  return std::move(archive).finish();
}

}  // namespace conddp
