#pragma once
// An SQLite database and its statements, with errors as exceptions. Who includes this links SQLite.

#include "mesh/base/error.h"

#include <sqlite3.h>

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

namespace retractor::datasets {

struct CloseSqlite {
    void operator()(sqlite3* database) const { sqlite3_close_v2(database); }
    void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};

/// A database with its name for messages.
struct SqliteDatabase {
    std::unique_ptr<sqlite3, CloseSqlite> handle;
    std::string file; ///< put into IoError::where()
    std::string trouble = "the database cannot be used"; ///< begin of the messages

    [[noreturn]] void fail() const { throw IoError(trouble + ": " + sqlite3_errmsg(handle.get()), file); }
    /// Runs statements that give no rows. @throws IoError
    void run(const std::string& sql) const
    {
        if (sqlite3_exec(handle.get(), sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK)
            fail();
    }
};

/// Opens a file, or creates it. ":memory:" is a database in memory. @throws IoError
inline SqliteDatabase open_sqlite(const std::filesystem::path& file, std::string trouble)
{
    SqliteDatabase database { .handle = nullptr, .file = file.string(), .trouble = std::move(trouble) };
    sqlite3* handle = nullptr;
    const int opened
        = sqlite3_open_v2(database.file.c_str(), &handle, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, nullptr);
    database.handle.reset(handle);
    if (opened != SQLITE_OK)
        database.fail();
    constexpr int kPatienceMs = 5000; // waits while another program writes
    sqlite3_busy_timeout(handle, kPatienceMs);
    return database;
}

/// A prepared statement with its values. Values are bound in order, columns are numbered from 0.
/// @pre the database outlives the statement
class SqliteStatement {
public:
    SqliteStatement(const SqliteDatabase& database, std::string_view sql)
        : database_(database)
    {
        sqlite3_stmt* statement = nullptr;
        if (sqlite3_prepare_v2(database.handle.get(), sql.data(), static_cast<int>(sql.size()), &statement, nullptr)
            != SQLITE_OK)
            database.fail();
        statement_.reset(statement);
    }

    SqliteStatement& bind(std::string_view text)
    {
        return checked(sqlite3_bind_text(
            statement_.get(), ++bound_, text.data(), static_cast<int>(text.size()), SQLITE_TRANSIENT));
    }
    SqliteStatement& bind(double value) { return checked(sqlite3_bind_double(statement_.get(), ++bound_, value)); }
    SqliteStatement& bind(int value) { return checked(sqlite3_bind_int(statement_.get(), ++bound_, value)); }
    SqliteStatement& bind_null() { return checked(sqlite3_bind_null(statement_.get(), ++bound_)); }

    /// @return whether there is a row
    bool step()
    {
        const int result = sqlite3_step(statement_.get());
        if (result != SQLITE_ROW && result != SQLITE_DONE)
            database_.fail();
        return result == SQLITE_ROW;
    }
    /// Makes the statement ready for other values.
    void reset()
    {
        sqlite3_reset(statement_.get());
        bound_ = 0;
    }

    std::string text(int column) const
    {
        const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(statement_.get(), column));
        return bytes == nullptr
            ? std::string()
            : std::string(bytes, static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column)));
    }
    double number(int column) const { return sqlite3_column_double(statement_.get(), column); }
    int integer(int column) const { return sqlite3_column_int(statement_.get(), column); }
    sqlite3_stmt* handle() const { return statement_.get(); }

private:
    SqliteStatement& checked(int result)
    {
        if (result != SQLITE_OK)
            database_.fail();
        return *this;
    }

    const SqliteDatabase& database_;
    std::unique_ptr<sqlite3_stmt, CloseSqlite> statement_;
    int bound_ = 0;
};

} // namespace retractor::datasets
