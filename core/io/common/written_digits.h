// How far the numbers of a file may be from what was meant: files round. Coordinates of one plane
// are off it by that much.
//
// A text says how it rounds by its digits. With S the most significant digits that a number of the
// file has, and D the most decimals, a number x in [10^e, 10^(e+1)) is within half of 10^(e+1-S),
// or of 10^-D if that is more: so both `%.6g` and `%.6f` are told. A file whose numbers are short
// because they are round (0, 1, 0.5) does not round that much: never more than with six digits of
// its largest number. Numbers of eight digits and more that all are those of floats are floats.
// Else a file with 16 digits and more has doubles. Then all are within the last bit of the largest
// one, as coordinates of such a file were computed with those bits.
#ifndef DYNMESH_CORE_IO_COMMON_WRITTEN_DIGITS_H_
#define DYNMESH_CORE_IO_COMMON_WRITTEN_DIGITS_H_

#include <string_view>

namespace dynmesh::io {

// A function from a coordinate to the largest distance from what was meant. Plain data, pure.
struct NumberRounding {
  double least = 0;  // at any coordinate
  double most = 0;   // the same as `least`: at all
  int digits = 17;   // S
  // 10^-D / 2.
  double last_decimal = 0;

  // > 0 unless all coordinates are 0. O(1).
  double Of(double coordinate) const;
};

// Collects the numbers of a file. Thread-compatible. O(length of the number) each.
class WrittenDigits {
 public:
  // A number as a text has it, and its value.
  void Add(std::string_view number, double value);
  // A number of a binary file.
  void AddFloat(float value);
  void AddDouble(double value);

  NumberRounding Rounding() const;

 private:
  void AddMagnitude(double value);

  double largest_ = 0;
  int digits_ = 0, decimals_ = 0;
  bool is_text_ = false, is_double_ = false;
  bool has_floats_ = true;  // each number is that of a float, as far as it is written
};

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_COMMON_WRITTEN_DIGITS_H_
