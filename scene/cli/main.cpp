// The program's entry.
#include <cstdio>

int main() {
  std::puts("obscura " OBSCURA_VERSION);
  return 0;
}
