#include "arguments/command_words.hpp"

#include <algorithm>

namespace conddp {
namespace {

/// Finds an option by its name, including dashes.
const Argument* find_option(const Command& command, const std::string& flag) {
  for (const Argument* option : command.options())
    if (std::find(option->names.begin(), option->names.end(), flag) != option->names.end())
      return option;
  return nullptr;
}

class Reader {
 public:
  Reader(const Command& tool, const std::vector<std::string>& arguments)
      : tool_(tool), words_{.command = &tool}, arguments_(arguments) {}

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
    if (words_.command == &tool_) {
      if (const Command* sub = tool_.find(word))
        words_.command = sub;
      else
        words_.unknown_command = word;
      return;
    }
    const auto places = words_.command->positionals();
    if (position_ < places.size()) {
      words_.values.emplace_back(places[position_], word);
      if (!places[position_]->repeatable()) ++position_;
    } else if (words_.extra.empty()) {
      words_.extra = word;
    }
  }

  void long_flag(const std::string& word) {
    const std::size_t equals = word.find('=');
    const Argument* option = known(word.substr(0, equals));
    if (option == nullptr) return;
    if (equals != word.npos)
      words_.values.emplace_back(option, word.substr(equals + 1));
    else
      take_value(*option);
  }

  /// Examples: -vo DIR, -oDIR.
  void short_flags(const std::string& word) {
    for (std::size_t i = 1; i < word.size(); ++i) {
      const Argument* option = known(std::string("-") + word[i]);
      if (option == nullptr) return;
      if (option->flag()) continue;
      if (i + 1 < word.size())
        words_.values.emplace_back(option, word.substr(i + 1));
      else
        take_value(*option);
      return;
    }
  }

  const Argument* known(const std::string& flag) {
    const Argument* option = find_option(*words_.command, flag);
    if (option == nullptr && words_.unknown_flag.empty()) words_.unknown_flag = flag;
    return option;
  }

  void take_value(const Argument& option) {
    const auto& choices = option.choices;
    const bool may_follow =
        !option.flag() || (at_ + 1 < arguments_.size() &&
                           std::ranges::find(choices, arguments_[at_ + 1]) != choices.end());
    if (!may_follow) return;
    if (at_ + 1 < arguments_.size())
      words_.values.emplace_back(&option, arguments_[++at_]);
    else
      words_.incomplete = &option;
  }

  const Command& tool_;
  CommandWords words_;
  const std::vector<std::string>& arguments_;
  std::size_t at_ = 0;
  std::size_t position_ = 0;
};

}  // namespace

std::string CommandWords::value_of(const std::string& option) const {
  std::string found;
  for (const auto& [known, value] : values)
    if (known->names.back() == option) found = value;
  return found;
}

CommandWords read_words(const Command& tool, const std::vector<std::string>& arguments) {
  return Reader(tool, arguments).read();
}

}  // namespace conddp
