// Where things are on this machine. Only places.cpp knows, so that all else compiles alike in every checkout.
#pragma once

#include <string>

namespace obscura::test {

std::string source_file(const std::string& name);  ///< of the project, from its root
std::string shared_path(const std::string& name);  ///< of the folder beside the checkout; it may be absent
std::string data_file(const std::string& name);    ///< of tests/data
std::string program_file();                        ///< the built program

}  // namespace obscura::test
