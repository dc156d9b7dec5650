// The table of residuals and the values of their keys.
#include "problem_file/residuals/residual_table.hpp"

#include <set>

#include <gtest/gtest.h>

namespace conddp {
namespace {

TEST(ResidualTable, EveryDefinitionIsDescribedAndHasOneMaker) {
  std::set<std::string_view> names;
  for (const ResidualDefinition* residual : residual_table()) {
    SCOPED_TRACE(residual->name);
    EXPECT_TRUE(names.insert(residual->name).second);
    EXPECT_FALSE(residual->description.empty());
    EXPECT_FALSE(residual->unit.empty());
    EXPECT_NE(residual->make == nullptr, residual->make_of_contact == nullptr);
    EXPECT_EQ(residual->of_contacts(), residual->has("contacts"));
    EXPECT_TRUE(!residual->is_cone || residual->set_activation != nullptr);
    EXPECT_EQ(find_residual(residual->name), residual);
  }
  EXPECT_EQ(find_residual("power"), nullptr);
  EXPECT_FALSE(find_residual("control_rate")->at_last_node());
  EXPECT_FALSE(find_residual("contact_force")->at_last_node());
  EXPECT_TRUE(find_residual("contact_velocity")->at_last_node());
}

TEST(ResidualTable, EveryKeyHasOneMeaning) {
  std::set<std::string_view> names;
  for (const ResidualKey* key : residual_keys()) {
    SCOPED_TRACE(key->info.name);
    EXPECT_TRUE(names.insert(key->info.name).second);
    EXPECT_FALSE(key->info.says.empty());
    EXPECT_TRUE(key->visit);
    EXPECT_TRUE(key->stands_in({}));
  }
  for (const ResidualDefinition* residual : residual_table())
    for (const ResidualKey* key : residual->keys) EXPECT_TRUE(names.contains(key->info.name));
}

TEST(KeyValues, TakeTheLastSettingOrTheFallback) {
  const Key<int> faces{"faces", 4};
  const Key<std::vector<std::string>> names{"names"};
  KeyValues values;
  EXPECT_EQ(values.find(faces), nullptr);
  EXPECT_EQ(values.value(faces), 4);
  EXPECT_FALSE(values.has("faces"));
  values.set(faces, 6);
  values.set(names, {"a", "b"});
  values.set(faces, 8);
  ASSERT_NE(values.find(faces), nullptr);
  EXPECT_EQ(*values.find(faces), 8);
  EXPECT_EQ(values.value(names), (std::vector<std::string>{"a", "b"}));
  EXPECT_TRUE(values.has("faces"));
  const KeyValues copy = values;
  values.set(faces, 3);
  EXPECT_EQ(copy.value(faces), 8);
}

}  // namespace
}  // namespace conddp
