// Compiled for any x86-64, unlike the rest of the tool, to select the instruction set before other
// code runs. A tool for wider registers may be installed next to this one (cmake/wider_tool.cmake).
// If the processor supports it, the process becomes that tool. If the processor lacks instructions
// of this tool, it reports them instead of ending at an illegal instruction.
#include <cstdlib>
#include <cstring>

#include <unistd.h>

// From cmake/processor_features.cmake, where X("name") stands for each relevant instruction set:
// CONDDP_PROCESSOR_FEATURES, CONDDP_INSTRUCTION_SET (the path of this tool: "avx2") and, if there
// is a wider tool, CONDDP_WIDER_FEATURES and CONDDP_WIDER_SET.
#ifndef CONDDP_WIDER_SET
#define CONDDP_WIDER_SET ""
#define CONDDP_WIDER_FEATURES
#endif

namespace {

constexpr const char* kVariable = "CONDDP_INSTRUCTIONS";

/// A text without std::string and streams, which are compiled for the other processor.
struct Text {
  char characters[1024] = {};
  std::size_t size = 0;

  void add(const char* words) {
    while (*words != 0 && size + 1 < sizeof(characters)) characters[size++] = *words++;
    characters[size] = 0;
  }
};

[[noreturn]] void fail(const Text& message) {
  if (write(2, message.characters, message.size) < 0) _exit(3);
  _exit(2);
}

#define X(feature)                            \
  if (__builtin_cpu_supports(feature) == 0) { \
    missing.add(" ");                         \
    missing.add(feature);                     \
  }

/// Instruction sets of this tool that the processor lacks.
Text missing_here() {
  Text missing;
  CONDDP_PROCESSOR_FEATURES
  return missing;
}

/// Instruction sets of the wider tool that the processor lacks.
Text missing_for_wider() {
  Text missing;
  CONDDP_WIDER_FEATURES
  return missing;
}
#undef X

void report_unknown_path(const char* wanted) {
  Text message;
  message.add("conddp: error: ");
  message.add(kVariable);
  message.add(" is '");
  message.add(wanted);
  message.add("', but this conddp has ");
  message.add(CONDDP_INSTRUCTION_SET);
  if (*CONDDP_WIDER_SET != 0) message.add(" and " CONDDP_WIDER_SET);
  message.add(
      "\n"
      "  hint: leave the variable unset for the widest that the processor has\n");
  fail(message);
}

void report_missing(const Text& missing, const char* whose, const char* hint) {
  Text message;
  message.add("conddp: error: this processor lacks");
  message.add(missing.characters);
  message.add(", which ");
  message.add(whose);
  message.add(" was compiled for\n  hint: ");
  message.add(hint);
  message.add("\n");
  fail(message);
}

/// Returns only if the wider tool cannot be run; `path` is the path that was tried.
void become_wider(char** argv, Text& path) {
  char self[sizeof(path.characters)];
  const ssize_t size = readlink("/proc/self/exe", self, sizeof(self) - 1);
  if (size <= 0) return;
  self[size] = 0;
  path.add(self);
  path.add("-" CONDDP_WIDER_SET);
  execve(path.characters, argv, environ);
}

/// Runs before the constructors of all other objects. The C library passes it the arguments of
/// main.
__attribute__((constructor(101))) void choose_instructions(int, char** argv, char**) {
  __builtin_cpu_init();
  const char* wanted = std::getenv(kVariable);
  if (wanted != nullptr && *wanted == 0) wanted = nullptr;
  const bool has_wider = *CONDDP_WIDER_SET != 0;
  if (wanted == nullptr) {
    Text path;
    if (has_wider && missing_for_wider().size == 0) become_wider(argv, path);
  } else if (has_wider && std::strcmp(wanted, CONDDP_WIDER_SET) == 0) {
    if (const Text missing = missing_for_wider(); missing.size > 0)
      report_missing(missing, "the " CONDDP_WIDER_SET " path",
                     "leave CONDDP_INSTRUCTIONS unset for the widest that the processor has");
    Text path, message;
    become_wider(argv, path);
    message.add("conddp: error: the " CONDDP_WIDER_SET " path cannot be run: ");
    message.add(path.characters);
    message.add("\n  hint: keep that file beside conddp, or leave CONDDP_INSTRUCTIONS unset\n");
    fail(message);
  } else if (std::strcmp(wanted, CONDDP_INSTRUCTION_SET) != 0) {
    report_unknown_path(wanted);
  }
  if (const Text missing = missing_here(); missing.size > 0)
    report_missing(missing, "this conddp",
                   "compile it on this machine (preset release) or for all with avx2 (preset "
                   "portable)");
}

}  // namespace
