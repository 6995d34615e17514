//! Messages of the Robot Operating System.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use sigmatau_formats::ros::{self, Columns, End, Fault, LogKind, Program, RawStep};
use std::path::PathBuf;

/// Topic, number, type, encoding of the definition, definition, encoding of the messages, number of messages.
type ChannelFields = (String, u32, String, String, Vec<u8>, String, u64);
/// Kind of the fault (empty without a fault), offset, description.
type EndFields = (&'static str, u64, String);
type Decoded<'py> = (Vec<Bound<'py, PyArray1<f64>>>, Option<Bound<'py, PyArray1<i64>>>, usize);

/// Channels, whether their numbers of messages are declared, and where reading ended.
#[pyfunction]
pub fn log_contents(
    py: Python<'_>,
    path: PathBuf,
    bag: bool,
    most: u64,
) -> PyResult<(Vec<ChannelFields>, bool, EndFields)> {
    let contents = py.detach(|| ros::contents(&path, kind(bag), most))?;
    let channels = contents.channels.into_iter();
    let fields = channels
        .map(|c| {
            (c.topic, c.id, c.type_name, c.definition_encoding, c.definition, c.message_encoding, c.messages)
        })
        .collect();
    Ok((fields, contents.declared, end_fields(contents.end)))
}

#[pyfunction]
#[allow(clippy::too_many_arguments)] // the arguments of `_native.logs`
pub fn log_messages(
    py: Python<'_>,
    path: PathBuf,
    bag: bool,
    channels: Vec<u32>,
    steps: Vec<RawStep>,
    cdr: bool,
    wanted: Vec<usize>,
    exact: Option<usize>,
    most: u64,
) -> PyResult<(Decoded<'_>, EndFields)> {
    let program = compiled(&steps, cdr, &wanted, exact)?;
    let decoded = py.detach(|| ros::messages(&path, kind(bag), &channels, &program, most))?;
    Ok((arrays(py, decoded.columns), end_fields(decoded.end)))
}

/// Decodes concatenated messages in memory; the rows end before the first incomplete message.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // the arguments of `_native.logs`
pub fn decode_messages<'py>(
    py: Python<'py>,
    data: &[u8],
    ends: PyReadonlyArray1<'py, i64>,
    log_times: PyReadonlyArray1<'py, i64>,
    steps: Vec<RawStep>,
    cdr: bool,
    wanted: Vec<usize>,
    exact: Option<usize>,
) -> PyResult<Decoded<'py>> {
    let program = compiled(&steps, cdr, &wanted, exact)?;
    let (ends, log_times) = (ends.as_slice()?, log_times.as_slice()?);
    let columns = py.detach(|| {
        let mut columns = program.columns();
        let ends: Vec<usize> = ends.iter().map(|&end| end as usize).collect();
        program.decode(data, &ends, log_times, &mut columns);
        columns
    });
    Ok(arrays(py, columns))
}

/// Decompresses a message (zstd); None if it is damaged or too large.
#[pyfunction]
pub fn unpacked<'py>(py: Python<'py>, data: &[u8]) -> Option<Bound<'py, PyBytes>> {
    py.detach(|| ros::unpacked(data)).map(|message| PyBytes::new(py, &message))
}

fn kind(bag: bool) -> LogKind {
    if bag { LogKind::Bag } else { LogKind::Mcap }
}

fn compiled(steps: &[RawStep], cdr: bool, wanted: &[usize], exact: Option<usize>) -> PyResult<Program> {
    Program::compile(steps, cdr, wanted, exact).map_err(|error| PyValueError::new_err(error.to_string()))
}

fn arrays(py: Python<'_>, columns: Columns) -> Decoded<'_> {
    let floats = columns.floats.into_iter().map(|c| c.into_pyarray(py)).collect();
    (floats, columns.exact.map(|c| c.into_pyarray(py)), columns.rows)
}

fn end_fields(end: End) -> EndFields {
    let kind = match end.fault {
        Fault::None => "",
        Fault::BrokenOff => "broken_off",
        Fault::NoEnd => "no_end",
        Fault::Damaged => "damaged",
        Fault::BytesAfterEnd => "behind",
        Fault::Filler => "filler",
        Fault::Expanded => "expanded",
    };
    (kind, end.offset, end.what)
}
