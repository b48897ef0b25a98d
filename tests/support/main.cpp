// The one translation unit that compiles Catch's main.
#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>
