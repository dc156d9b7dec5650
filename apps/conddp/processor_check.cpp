// Compiled for any x86-64, unlike the rest of the tool: before anything of that runs, it looks
// whether the processor has the instructions that the rest was compiled to, and says what is
// missing instead of ending at an illegal instruction.
#include <unistd.h>

namespace {

/// As strings and streams are compiled for the other processor, it does without.
struct Text {
  char characters[512];
  unsigned size = 0;

  void add(const char* words) {
    while (*words != 0 && size < sizeof(characters)) characters[size++] = *words++;
  }
};

/// Before the constructors of all other objects.
__attribute__((constructor(101))) void check_processor() {
  __builtin_cpu_init();
  Text message;
  message.add("conddp: error: this processor lacks");
  const unsigned found_nothing = message.size;
#define X(feature)                            \
  if (__builtin_cpu_supports(feature) == 0) { \
    message.add(" ");                         \
    message.add(feature);                     \
  }
  // X("name") for every instruction set that matters, from cmake/processor_features.cmake.
  CONDDP_PROCESSOR_FEATURES
#undef X
  if (message.size == found_nothing) return;
  message.add(
      ", which this conddp was compiled for\n"
      "  hint: compile it on this machine (preset release) or for all with avx2 (preset "
      "portable)\n");
  if (write(2, message.characters, message.size) < 0) _exit(3);
  _exit(2);
}

}  // namespace
