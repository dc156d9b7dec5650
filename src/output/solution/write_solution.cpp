#include "output/solution/write_solution.hpp"

#include "base/files/atomic_file.hpp"
#include "base/json/json_text.hpp"
#include "output/solution/csv.hpp"

namespace conddp {

std::vector<std::filesystem::path> write_solution(const Solution& solution,
                                                  const OrderedJson& document,
                                                  const std::filesystem::path& folder,
                                                  const std::string& page) {
  create_folder(folder);
  std::vector<std::filesystem::path> paths = {folder / "solution.json", folder / "trajectory.csv",
                                              folder / "iterations.csv"};
  AtomicFiles files;
  files.add(paths[0], json_text(document));
  files.add(paths[1],
            trajectory_csv(solution.built, solution.result.trajectory, solution.answer.forces));
  files.add(paths[2], iterations_csv(document.at("log")));
  if (!page.empty()) files.add(paths.emplace_back(folder / "report.html"), page);
  files.commit();
  if (page.empty()) {  // an existing page shows an earlier answer
    std::error_code ignored;
    std::filesystem::remove(folder / "report.html", ignored);
  }
  return paths;
}

}  // namespace conddp
