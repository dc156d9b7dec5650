#include "problem_file/data/height_map.hpp"
#include "problem_file/read/read_sections.hpp"

namespace conddp {

static void describe(Keys& keys, HeightMapSpec& map) {
  keys.about({.definition = "height_map",
              .title = "Height map",
              .says = "Heights over a regular grid; bicubic convolution interpolates",
              .examples = R"([{"file": "hills.csv", "cell": 0.1, "origin": [-1, -2, 0]}])"});
  keys({.name = "file",
        .says =
            "A CSV file, whose numbers are heights, or a gray PGM or PNG image, whose values are, "
            "relative to the problem file; lines follow along y from the origin, numbers along "
            "x",
        .required = true},
       map.file, NameForm{});
  keys({.name = "cell",
        .says = "Distance of neighbouring numbers along x and y, m",
        .required = true},
       map.cell, NumberForm{kPositive});
  keys({"origin", "Place of the file's first number; heights are above it, m"}, map.origin,
       VectorForm{"[x, y, z] in m"});
  keys({"scale", "Meters in the unit of the file's numbers"}, map.scale, NumberForm{});
  if (YamlMap* reading = keys.reading(); reading != nullptr && !map.file.value.empty())
    load_heights(reading->reader().folder(), map, reading->reader().diagnostics());
}

void describe(Keys& keys, TerrainPieceSpec& piece) {
  keys.about({.definition = "terrain_piece",
              .title = "Piece of the terrain",
              .says = "A box, a half-space or a height map, in the world",
              .examples = R"([{"box": {"size": [0.3, 1, 0.15],
                                       "placement": {"position": [0.6, 0, 0.075]}}},
                              {"height_map": {"file": "hills.csv", "cell": 0.1}}])",
              .rules = R"("oneOf": [{"required": ["box"]}, {"required": ["half_space"]},
                                    {"required": ["height_map"]}])"});
  keys({"box"}, piece.form, AlternativeForm<BoxSpec>{});
  keys({"half_space"}, piece.form, AlternativeForm<HalfSpaceSpec>{});
  keys({"height_map"}, piece.form, AlternativeForm<HeightMapSpec>{});
  YamlMap* map = keys.reading();
  if (map == nullptr) return;
  check_form(map, {"box", "half_space", "height_map"}, "give 'box', 'half_space' or 'height_map'");
  constexpr double kSteepest = 0.1;  // the cosine of about 84 degrees
  const auto* plane = std::get_if<HalfSpaceSpec>(&piece.form);
  if (const auto r = map->find("half_space"); r && plane != nullptr && plane->normal.z < kSteepest)
    r->error("the normal of ground points upward", "write 'normal: [0, 0, 1]', or a slope's");
}

void stand_on_terrain(const YamlReader& mpc, ProblemSpec& spec) {
  const YamlNode* plant = mpc.node().find("plant");
  if (plant == nullptr || plant->find("ground") != nullptr || !spec.mpc->plant.simulated_contacts)
    return;
  std::vector<TouchedSpec> ground;
  for (const TerrainPieceSpec& piece : spec.terrain) {
    const auto add = [&](const auto& form) {
      ground.push_back({.place = piece.name.place, .form = form});
    };
    if (const auto* box = std::get_if<BoxSpec>(&piece.form)) add(*box);
    if (const auto* plane = std::get_if<HalfSpaceSpec>(&piece.form)) add(*plane);
  }
  if (!ground.empty()) spec.mpc->plant.ground = std::move(ground);
}

}  // namespace conddp
