// Prints the path chosen by processor_check.cpp and its arguments.
#include <cstdio>

int main(int argc, char** argv) {
  std::printf("%s", CONDDP_INSTRUCTION_SET);
  for (int i = 1; i < argc; ++i) std::printf(" %s", argv[i]);
  std::printf("\n");
}
