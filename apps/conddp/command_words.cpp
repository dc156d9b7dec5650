#include "command_words.hpp"

#include <algorithm>

namespace conddp {
namespace {

const CLI::App* find_command(const CLI::App& app, const std::string& name) {
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; }))
    if (sub->get_name() == name) return sub;
  return nullptr;
}

/// An option by its name with dashes.
const CLI::Option* find_option(const CLI::App& app, const std::string& flag) {
  for (const CLI::Option* option : app.get_options()) {
    const auto& names = flag.starts_with("--") ? option->get_lnames() : option->get_snames();
    const std::string name = flag.substr(flag.starts_with("--") ? 2 : 1);
    if (std::find(names.begin(), names.end(), name) != names.end()) return option;
  }
  return nullptr;
}

std::vector<const CLI::Option*> positionals(const CLI::App& app) {
  std::vector<const CLI::Option*> list;
  for (const CLI::Option* option : app.get_options())
    if (option->get_positional()) list.push_back(option);
  return list;
}

class Reader {
 public:
  Reader(const CLI::App& app, const std::vector<std::string>& arguments)
      : words_{.command = &app}, arguments_(arguments) {}

  CommandWords read() {
    bool flags_end = false;
    for (; at_ < arguments_.size() && words_.unknown_command.empty(); ++at_) {
      const std::string& word = arguments_[at_];
      if (flags_end || !word.starts_with('-') || word == "-")
        bare(word);
      else if (word == "--")
        flags_end = true;
      else if (word.starts_with("--"))
        long_flag(word);
      else
        short_flags(word);
    }
    return std::move(words_);
  }

 private:
  void bare(const std::string& word) {
    if (words_.command->get_parent() == nullptr) {
      if (const CLI::App* sub = find_command(*words_.command, word))
        words_.command = sub;
      else
        words_.unknown_command = word;
      return;
    }
    const auto places = positionals(*words_.command);
    if (position_ < places.size()) {
      words_.values.emplace_back(places[position_], word);
      if (places[position_]->get_items_expected_max() == 1) ++position_;
    } else if (words_.extra.empty()) {
      words_.extra = word;
    }
  }

  void long_flag(const std::string& word) {
    const std::size_t equals = word.find('=');
    const CLI::Option* option = known(word.substr(0, equals));
    if (option == nullptr) return;
    if (equals != word.npos)
      words_.values.emplace_back(option, word.substr(equals + 1));
    else
      take_value(*option);
  }

  /// -vo DIR, -oDIR
  void short_flags(const std::string& word) {
    for (std::size_t i = 1; i < word.size(); ++i) {
      const CLI::Option* option = known(std::string("-") + word[i]);
      if (option == nullptr) return;
      if (option->get_items_expected_max() == 0) continue;
      if (i + 1 < word.size())
        words_.values.emplace_back(option, word.substr(i + 1));
      else
        take_value(*option);
      return;
    }
  }

  const CLI::Option* known(const std::string& flag) {
    const CLI::Option* option = find_option(*words_.command, flag);
    if (option == nullptr && words_.unknown_flag.empty()) words_.unknown_flag = flag;
    return option;
  }

  void take_value(const CLI::Option& option) {
    if (option.get_items_expected_max() == 0) return;
    if (at_ + 1 < arguments_.size())
      words_.values.emplace_back(&option, arguments_[++at_]);
    else
      words_.incomplete = &option;
  }

  CommandWords words_;
  const std::vector<std::string>& arguments_;
  std::size_t at_ = 0;
  std::size_t position_ = 0;
};

}  // namespace

std::string CommandWords::value_of(const std::string& option) const {
  std::string found;
  for (const auto& [known, value] : values)
    if (known->check_lname(option)) found = value;
  return found;
}

CommandWords read_words(const CLI::App& app, const std::vector<std::string>& arguments) {
  return Reader(app, arguments).read();
}

}  // namespace conddp
