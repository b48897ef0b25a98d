// The program's entry.
#include "commands.h"

int main(int argc, char** argv) { return obscura::cli::run_program(argc, argv); }
