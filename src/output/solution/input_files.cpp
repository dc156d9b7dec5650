#include "output/solution/input_files.hpp"

namespace conddp {

InputFiles input_files(const BuiltProblem& built) {
  InputFiles files{.data = built.data_files};
  for (const PlantPart& part : built.plant.parts)
    files.robots.push_back({part.spec->path.string(), part.sha256});
  return files;
}

OrderedJson files_json(const std::vector<InputFile>& files) {
  OrderedJson list = OrderedJson::array();
  for (const InputFile& file : files)
    list.push_back({{"file", file.file}, {"sha256", file.sha256}});
  return list;
}

}  // namespace conddp
