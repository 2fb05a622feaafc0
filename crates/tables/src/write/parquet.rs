use ::parquet::basic::{Compression, Encoding, Repetition, Type as Stored, ZstdLevel};
use ::parquet::column::writer::{ColumnCloseResult, get_column_writer, get_typed_column_writer};
use ::parquet::data_type::DoubleType;
use ::parquet::errors::Result;
use ::parquet::file::properties::{EnabledStatistics, WriterProperties};
use ::parquet::file::writer::{SerializedFileWriter, SerializedPageWriter, TrackedWrite};
use ::parquet::schema::types::{ColumnDescPtr, Type};
use bytes::Bytes;
use rayon::prelude::*;
use std::io::{self, Write};
use std::sync::Arc;

/// Most rows of a row group.
const GROUP_ROWS: usize = 1 << 17;
/// Most numbers of a row group, unless one row alone has more.
const GROUP_NUMBERS: usize = 1 << 24;

/// Row groups of a fixed size.
pub struct Groups {
    file: SerializedFileWriter<Box<dyn Write + Send>>,
    /// Rows of a group.
    rows: usize,
    /// Values of the group that is not full yet.
    values: Vec<Vec<f64>>,
}

impl Groups {
    pub fn new(output: impl Write + Send + 'static, columns: &[&str]) -> io::Result<Self> {
        let field = |name: &&str| {
            let field = Type::primitive_type_builder(name, Stored::DOUBLE);
            Ok(Arc::new(field.with_repetition(Repetition::OPTIONAL).build()?))
        };
        let fields = columns.iter().map(field).collect::<Result<_>>()?;
        let schema = Type::group_type_builder("table").with_fields(fields).build()?;
        let properties = WriterProperties::builder()
            .set_dictionary_enabled(false)
            .set_encoding(Encoding::BYTE_STREAM_SPLIT)
            .set_compression(Compression::ZSTD(ZstdLevel::default()))
            .set_statistics_enabled(EnabledStatistics::Chunk)
            .build();
        let output = Box::new(output) as Box<dyn Write + Send>;
        Ok(Groups {
            file: SerializedFileWriter::new(output, Arc::new(schema), Arc::new(properties))?,
            rows: (GROUP_NUMBERS / columns.len()).clamp(1, GROUP_ROWS),
            values: vec![Vec::new(); columns.len()],
        })
    }

    pub fn write(&mut self, columns: &[&[f64]]) -> io::Result<()> {
        let mut start = 0;
        while start < columns[0].len() {
            let end = columns[0].len().min(start + self.rows - self.values[0].len());
            for (values, column) in self.values.iter_mut().zip(columns) {
                values.extend_from_slice(&column[start..end]);
            }
            start = end;
            if self.values[0].len() == self.rows {
                self.write_group()?;
            }
        }
        Ok(())
    }

    fn write_group(&mut self) -> Result<()> {
        let properties = self.file.properties().clone();
        let schema = self.file.schema_descr();
        let encoded: Result<Vec<_>> = self
            .values
            .par_iter_mut()
            .zip(schema.columns())
            .map(|(values, kind)| {
                let encoded = encode(values, kind.clone(), properties.clone());
                values.clear();
                encoded
            })
            .collect();
        let mut group = self.file.next_row_group()?;
        for (bytes, close) in encoded? {
            group.append_column(&bytes, close)?;
        }
        group.close()?;
        Ok(())
    }

    pub fn finish(mut self) -> io::Result<()> {
        if !self.values[0].is_empty() {
            self.write_group()?;
        }
        self.file.finish()?;
        self.file.inner_mut().flush()
    }
}

/// One column of a row group, as it stands in the file.
fn encode(
    values: &[f64],
    kind: ColumnDescPtr,
    properties: Arc<WriterProperties>,
) -> Result<(Bytes, ColumnCloseResult)> {
    let mut bytes = TrackedWrite::new(Vec::new());
    let pages = SerializedPageWriter::new(&mut bytes);
    let mut column =
        get_typed_column_writer::<DoubleType>(get_column_writer(kind, properties, Box::new(pages)));
    let levels: Vec<i16> = values.iter().map(|value| i16::from(!value.is_nan())).collect();
    let present: Vec<f64> = values.iter().copied().filter(|value| !value.is_nan()).collect();
    column.write_batch(&present, Some(&levels), None)?;
    let close = column.close()?;
    Ok((bytes.into_inner()?.into(), close))
}
