#pragma once
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include "genphys/v1/limits.pb.h"

/// Small things that the generator of limit cases and the tests of the declarations do to fields. They read the limits
/// anew from the options, and not through the validator, which they are there to test.
namespace genphys {

/// What is declared on `field` itself.
const v1::Limit& LimitOf(const google::protobuf::FieldDescriptor* field);

/// The limit that the fields of `type` take over from `holder`; null when they declare their own or nobody holds it.
const v1::Limit* InheritedLimit(const google::protobuf::Descriptor* type,
                                const google::protobuf::FieldDescriptor* holder);

/// Smallest and largest value of an integer type.
std::pair<double, double> RangeOfType(const google::protobuf::FieldDescriptor* field);

/// "field", or "field[0]" for a repeated one.
std::string ElementName(const google::protobuf::FieldDescriptor* field);

/// Sets a number or enum, or the first element of a repeated one. 2^64 stands for the largest uint64.
void SetNumber(google::protobuf::Message& message, const google::protobuf::FieldDescriptor* field, double value);
/// Sets a string, or the first element of a repeated one.
void SetText(google::protobuf::Message& message, const google::protobuf::FieldDescriptor* field,
             const std::string& text);

/// A text that `limit` accepts: the name of a resource where its pattern is one, else a letter.
std::string ExampleText(const v1::Limit& limit);

/// Sets required fields and the first alternative of every oneof. With `inherited`, makes a Vector3 or Quaternion that
/// this limit accepts.
void FillMessage(google::protobuf::Message& message, const v1::Limit* inherited);
/// FillMessage for a message that `holder` holds.
void FillHeld(google::protobuf::Message& message, const google::protobuf::FieldDescriptor* holder);

/// Makes a repeated field have `count` valid elements, the first ones being those it has. Leaves others alone.
void FillElements(google::protobuf::Message& message, const google::protobuf::FieldDescriptor* field, uint64_t count,
                  const std::function<void(google::protobuf::Message&)>& complete = {});
/// About what one element takes in memory and on the wire.
size_t BytesOfElement(const google::protobuf::FieldDescriptor* field);

/// Bytes of one scalar and of one row.
size_t BytesPerScalar(const v1::Column& column);
size_t BytesPerRow(const v1::Column& column);
/// Makes every column of `message` have the rows of the one that decides, `rows` of them if that one is empty.
void FillColumns(google::protobuf::Message& message, size_t rows);
/// Empties every column of `message`.
void ClearColumns(google::protobuf::Message& message);
/// Overwrites scalar `index` of a column.
void SetScalar(std::string& bytes, const v1::Column& column, size_t index, double value);
/// The neighbour of `value` in the direction of `towards`, in the type of the column's scalars.
double NextScalar(const v1::Column& column, double value, double towards);

}  // namespace genphys
