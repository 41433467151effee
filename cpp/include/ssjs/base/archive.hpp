/// The state of an object as bytes, and back, exact to the bit. One function a class does both, so that they cannot drift apart; it stands
/// behind the members and names each once:
///
///   class Window {
///     ...
///     double newest_s_ = 0.0;
///     std::vector<Sample> waiting_;
///
///    public:
///     void archive(Archive& a) {
///       a("newest_s", newest_s_);
///       a("waiting", waiting_);
///     }
///   };
///
/// Fields: numbers, enumerations, text, Eigen matrices, optional, array, vector, deque, set and map of them, and what has an archive() of
/// its own. What follows from other members, or from the configuration, is left out and made anew.
///
/// Bytes: integers and float64, little-endian; a count before what has no fixed size; before every field two bytes made of its name, so
/// that the bytes of another build, with other members, are refused and not misread. Reading takes nothing on trust: a count larger than
/// the bytes that are left, a number that is not finite, an enumerator out of its range are errors that name the field.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace ssjs {

class Archive {
 public:
  /// Writes.
  Archive() = default;
  /// Reads `bytes`, which have to outlive this; `source` is what errors call them.
  Archive(std::string_view bytes, std::string source) : reading_(true), in_(bytes), source_(std::move(source)) {}

  [[nodiscard]] bool reading() const { return reading_; }

  /// A field. Throws FileError (reading) or InvalidArgument (writing) naming it, with all that it lies in.
  template <class T>
  void operator()(std::string_view name, T& value) {
    const Inside inside(*this, name);
    check_name(name);
    item(value);
  }

  /// A field that may be infinite.
  void unbounded(std::string_view name, double& value);

  /// So many numbers, where other fields say how many.
  void numbers(std::string_view name, double* data, std::size_t count) {
    const Inside inside(*this, name);
    check_name(name);
    numbers(data, count);
  }

  /// An enumeration of 0, 1, ..., last.
  template <class Enum>
  void choice(std::string_view name, Enum& value, Enum last) {
    const Inside inside(*this, name);
    check_name(name);
    auto number = static_cast<std::int64_t>(value);
    item(number);
    if (number < 0 || number > static_cast<std::int64_t>(last)) fail("is " + std::to_string(number) + ", which is none of its values");
    if (reading_) value = static_cast<Enum>(number);
  }

  /// What has to hold between fields that were read, within the object that is being archived.
  void require(bool holds, const char* rule) const {
    if (!holds) fail(rule);
  }

  /// Reading: nothing may be left.
  void end() const;
  [[nodiscard]] std::size_t left() const { return in_.size(); }
  /// Writing: about so many bytes are to come.
  void reserve(std::size_t bytes) { out_.reserve(bytes); }
  /// Writing: what was written so far.
  [[nodiscard]] std::string take_bytes() { return std::move(out_); }

 private:
  struct Place {
    std::string_view name;
    std::size_t element;
  };
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  /// Where we are, for the messages.
  class Inside {
   public:
    Inside(Archive& archive, std::string_view name) : places_(archive.places_) { places_.push_back({name, kNone}); }
    Inside(const Inside&) = delete;
    Inside& operator=(const Inside&) = delete;
    ~Inside() { places_.pop_back(); }

   private:
    std::vector<Place>& places_;
  };

  template <class T, class = void>
  struct IsObject : std::false_type {};
  template <class T>
  struct IsObject<T, std::void_t<decltype(std::declval<T&>().archive(std::declval<Archive&>()))>> : std::true_type {};
  template <class T, class = void>
  struct IsMatrix : std::false_type {};
  template <class T>
  struct IsMatrix<T, std::void_t<decltype(T::RowsAtCompileTime), decltype(T::MaxRowsAtCompileTime)>> : std::true_type {};

  [[noreturn]] void fail(const std::string& what) const;
  void check_name(std::string_view name);
  void raw(void* data, std::size_t bytes);
  void numbers(double* data, std::size_t count);
  /// The number of elements, each of at least so many bytes.
  std::size_t count(std::size_t elements, std::size_t least_bytes);
  void check_size(std::int64_t size, std::int64_t fixed, std::int64_t most) const;

  void item(bool& value);
  void item(double& value) { numbers(&value, 1); }
  void item(std::string& text);
  void item(std::int64_t& value) { raw(&value, sizeof value); }

  template <class T>
  void item(T& value) {
    if constexpr (std::is_integral_v<T>) {
      auto number = static_cast<std::int64_t>(value);
      item(number);
      if (!reading_) return;  // others may be reading what is written down
      value = static_cast<T>(number);
      if (static_cast<std::int64_t>(value) != number || (std::is_unsigned_v<T> && number < 0)) {
        fail("is " + std::to_string(number) + ", out of its range");
      }
    } else if constexpr (IsObject<T>::value) {
      value.archive(*this);
    } else {
      static_assert(IsMatrix<T>::value, "a field of a kind that Archive does not know: give it an archive()");
      matrix(value);
    }
  }

  template <class Matrix>
  void matrix(Matrix& value) {
    static_assert(std::is_same_v<typename Matrix::Scalar, double> && !Matrix::IsRowMajor);
    std::int64_t rows = value.rows();
    std::int64_t columns = value.cols();
    if constexpr (Matrix::SizeAtCompileTime < 0) {
      item(rows);
      item(columns);
      check_size(rows, Matrix::RowsAtCompileTime, Matrix::MaxRowsAtCompileTime);
      check_size(columns, Matrix::ColsAtCompileTime, Matrix::MaxColsAtCompileTime);
      if (reading_) {
        if (columns > 0 && rows > static_cast<std::int64_t>(in_.size() / sizeof(double)) / columns)
          fail("is larger than the bytes that are left");
        value.resize(rows, columns);
      }
    }
    numbers(value.data(), static_cast<std::size_t>(rows * columns));
  }

  template <class T>
  void item(std::optional<T>& value) {
    bool has_value = value.has_value();
    item(has_value);
    if (reading_) value.reset();
    if (!has_value) return;
    item(reading_ ? value.emplace() : *value);
  }
  template <class A, class B>
  void item(std::pair<A, B>& value) {
    item(value.first);
    item(value.second);
  }
  template <class T, std::size_t Size>
  void item(std::array<T, Size>& values) {
    for (T& value : values) item(value);
  }
  void item(std::vector<double>& values) {
    const std::size_t size = count(values.size(), sizeof(double));
    if (reading_) values.resize(size);
    numbers(values.data(), size);
  }
  template <class T>
  void item(std::vector<T>& values) {
    sequence(values);
  }
  template <class T>
  void item(std::deque<T>& values) {
    sequence(values);
  }
  /// Grows with what is read, not with what is promised.
  template <class Sequence>
  void sequence(Sequence& values) {
    const std::size_t size = count(values.size(), 1);
    if (reading_) values.clear();
    for (std::size_t i = 0; i < size; ++i) {
      places_.back().element = i;
      item(reading_ ? values.emplace_back() : values[i]);
    }
    places_.back().element = kNone;
  }
  template <class Key, class T>
  void item(std::map<Key, T>& values) {
    const std::size_t size = count(values.size(), 1);
    if (!reading_) {
      for (auto& [key, value] : values) {
        Key name = key;
        item(name);
        item(value);
      }
      return;
    }
    values.clear();
    for (std::size_t i = 0; i < size; ++i) {
      Key name{};
      item(name);
      const auto [at, is_new] = values.try_emplace(name);
      if (!is_new) fail("holds a key twice");
      item(at->second);
    }
  }
  template <class Key>
  void item(std::set<Key>& values) {
    std::vector<Key> all(values.begin(), values.end());
    item(all);
    if (reading_) values = std::set<Key>(all.begin(), all.end());
  }

  bool reading_ = false;
  std::string out_;
  std::string_view in_;
  std::string source_;
  std::vector<Place> places_;
};

}  // namespace ssjs
