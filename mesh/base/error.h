#pragma once
// The three kinds of failure that are the caller's business. Expected outcomes (not converged,
// cancelled, the cut misses the body) are not errors: they are statuses in the results.

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace retractor {

/// Base of all errors thrown by this project. `where()` names the place: a file, a JSON pointer
/// ("/approaches/0/depth_mm"), a DICOM tag, an element or a vertex; empty when there is none.
/// `fields()` names the fields of a request that the user can change, as the request calls them ("depth_mm"); mostly
/// empty. A front end tells its users what it calls these fields itself: its options or its controls.
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

/// What the caller handed in is wrong: out of range, NaN, missing, contradictory.
class InputError : public Error {
public:
    using Error::Error;
};

/// A well-posed call could not be solved: singular, floating, indefinite.
class SolverError : public Error {
public:
    using Error::Error;
};

/// Reading or writing failed.
class IoError : public Error {
public:
    using Error::Error;
};

/// An exception as plain data: it can be kept, handed to another thread and shown.
struct Failure {
    std::string what;
    std::string where {}; ///< Error::where(); empty: the failure names no place
    std::vector<std::string> fields {}; ///< Error::fields()
};

/// "where: what"; "what" alone when the failure names no place.
std::string to_string(const Failure& failure);

/// The exception that is being handled. Call this function only inside a catch block.
Failure current_failure();

} // namespace retractor
