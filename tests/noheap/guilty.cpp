// What the link check must catch: an allocation, a throw, and a sine.
#include <cmath>
#include <string>

std::string* guilty(double x) {
  if (x < 0) throw 1;
  return new std::string(static_cast<std::size_t>(10 + std::sin(x)), 'x');
}
