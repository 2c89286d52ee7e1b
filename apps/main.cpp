#include "apps/command.h"
#include "apps/output_file.h"

int main(int argc, char** argv) {
  tribotrack::apps::clean_up_on_signals();
  return tribotrack::apps::run_program(argc, argv);
}
