#pragma once
// The three kinds of failure that a caller has to handle. Expected outcomes (not converged, cancelled, the cut misses
// the body) are no errors; results report them as a status.

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace retractor {

/// Base of all errors that this project throws. `where()` names the place: a file, a JSON pointer
/// ("/approaches/0/depth_mm"), a DICOM tag, an element or a vertex; `where()` is empty when there is no place.
/// `fields()` names the fields of a request that the user can change, as the request names them ("depth_mm");
/// `fields()` is mostly empty. A front end translates these names into its options or controls.
class Error : public std::runtime_error {
public:
    explicit Error(const std::string& what, std::string where = {}, std::vector<std::string> fields = {})
        : std::runtime_error(what)
        , where_(std::move(where))
        , fields_(std::move(fields))
    {
    }
    const std::string& where() const noexcept { return where_; }
    const std::vector<std::string>& fields() const noexcept { return fields_; }

private:
    std::string where_;
    std::vector<std::string> fields_;
};

/// The input is wrong: out of range, NaN, missing or contradictory.
class InputError : public Error {
public:
    using Error::Error;
};

/// A valid problem could not be solved: the matrix is singular or indefinite, or the body floats.
class SolverError : public Error {
public:
    using Error::Error;
};

/// Reading or writing a file failed.
class IoError : public Error {
public:
    using Error::Error;
};

/// An exception as plain data: it can be kept, handed to another thread and shown.
struct Failure {
    std::string what;
    std::string where {}; ///< Error::where(); empty when the failure names no place
    std::vector<std::string> fields {}; ///< Error::fields()
};

/// The text "where: what", or "what" alone when the failure names no place.
std::string to_string(const Failure& failure);

/// The exception that is being handled, as plain data. @pre called inside a catch block
Failure current_failure();

} // namespace retractor
