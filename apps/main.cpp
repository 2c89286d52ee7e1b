#include "apps/commands/command.h"
#include "apps/program/streams.h"
#include "apps/text/output_file.h"
#include "vision/frame_source.h"

int main(int argc, char** argv) {
  tribotrack::apps::occupy_standard_streams();
  tribotrack::apps::clean_up_on_signals();
  tribotrack::vision::keep_to_calling_thread();
  return tribotrack::apps::run_program(argc, argv);
}
