// Names the path that processor_check.cpp left it on, and its arguments.
#include <cstdio>

int main(int argc, char** argv) {
  std::printf("%s", CONDDP_INSTRUCTION_SET);
  for (int i = 1; i < argc; ++i) std::printf(" %s", argv[i]);
  std::printf("\n");
}
