//! Elements by number, and their keywords (DICOM PS3.6 2024): those that are kept, and those that have to be told from others.

use std::fmt;

/// Group and number of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Tag(pub u16, pub u16);

impl fmt::Display for Tag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "({:04X},{:04X})", self.0, self.1)
    }
}

impl Tag {
    /// True if the value is kept when a data set is read.
    pub fn is_kept(self) -> bool {
        KEPT.iter().any(|&(tag, _)| tag == self) || self.is_overlay_position()
    }

    /// True for a sequence, as far as this list tells: data sets without types do not say it.
    pub fn is_sequence(self) -> bool {
        self.keyword().is_some_and(|k| k.ends_with("Sequence"))
    }

    /// True for the bit at which an overlay lies; overlays come in groups 6000, 6002, … 601E.
    pub fn is_overlay_position(self) -> bool {
        self.1 == 0x0102 && (0x6000..=0x601e).contains(&self.0)
    }

    /// Keyword and number, as in `Rows (0028,0010)`.
    pub fn name(self) -> String {
        match self.keyword() {
            Some(keyword) => format!("{keyword} {self}"),
            None => format!("element {self}"),
        }
    }

    fn keyword(self) -> Option<&'static str> {
        KEPT.iter().chain(OTHERS).find(|(tag, _)| *tag == self).map(|&(_, keyword)| keyword)
    }
}

/// Constants for tags, and a list of them with their keywords.
macro_rules! tags {
    ($(#[$doc:meta])* $list:ident: $($group:literal $element:literal $name:ident $keyword:literal)*) => {
        $(pub(super) const $name: Tag = Tag($group, $element);)*
        $(#[$doc])*
        const $list: &[(Tag, &str)] = &[$(($name, $keyword)),*];
    };
}

tags! {
    /// Elements whose values are kept. None of them says who the patient is.
    KEPT:
    0x0002 0x0010 TRANSFER_SYNTAX_UID "TransferSyntaxUID"
    0x0008 0x0008 IMAGE_TYPE "ImageType"
    0x0008 0x0018 SOP_INSTANCE_UID "SOPInstanceUID"
    0x0008 0x0060 MODALITY "Modality"
    0x0008 0x103e SERIES_DESCRIPTION "SeriesDescription"
    0x0018 0x0050 SLICE_THICKNESS "SliceThickness"
    0x0018 0x0088 SPACING_BETWEEN_SLICES "SpacingBetweenSlices"
    0x0018 0x1164 IMAGER_PIXEL_SPACING "ImagerPixelSpacing"
    0x0020 0x000e SERIES_INSTANCE_UID "SeriesInstanceUID"
    0x0020 0x0011 SERIES_NUMBER "SeriesNumber"
    0x0020 0x0012 ACQUISITION_NUMBER "AcquisitionNumber"
    0x0020 0x0013 INSTANCE_NUMBER "InstanceNumber"
    0x0020 0x0032 IMAGE_POSITION_PATIENT "ImagePositionPatient"
    0x0020 0x0037 IMAGE_ORIENTATION_PATIENT "ImageOrientationPatient"
    0x0020 0x0100 TEMPORAL_POSITION_IDENTIFIER "TemporalPositionIdentifier"
    0x0020 0x9111 FRAME_CONTENT_SEQUENCE "FrameContentSequence"
    0x0020 0x9113 PLANE_POSITION_SEQUENCE "PlanePositionSequence"
    0x0020 0x9116 PLANE_ORIENTATION_SEQUENCE "PlaneOrientationSequence"
    0x0020 0x9128 TEMPORAL_POSITION_INDEX "TemporalPositionIndex"
    0x0028 0x0002 SAMPLES_PER_PIXEL "SamplesPerPixel"
    0x0028 0x0004 PHOTOMETRIC_INTERPRETATION "PhotometricInterpretation"
    0x0028 0x0006 PLANAR_CONFIGURATION "PlanarConfiguration"
    0x0028 0x0008 NUMBER_OF_FRAMES "NumberOfFrames"
    0x0028 0x0010 ROWS "Rows"
    0x0028 0x0011 COLUMNS "Columns"
    0x0028 0x0030 PIXEL_SPACING "PixelSpacing"
    0x0028 0x0100 BITS_ALLOCATED "BitsAllocated"
    0x0028 0x0101 BITS_STORED "BitsStored"
    0x0028 0x0102 HIGH_BIT "HighBit"
    0x0028 0x0103 PIXEL_REPRESENTATION "PixelRepresentation"
    0x0028 0x0120 PIXEL_PADDING_VALUE "PixelPaddingValue"
    0x0028 0x1050 WINDOW_CENTER "WindowCenter"
    0x0028 0x1051 WINDOW_WIDTH "WindowWidth"
    0x0028 0x1052 RESCALE_INTERCEPT "RescaleIntercept"
    0x0028 0x1053 RESCALE_SLOPE "RescaleSlope"
    0x0028 0x3000 MODALITY_LUT_SEQUENCE "ModalityLUTSequence"
    0x0028 0x9110 PIXEL_MEASURES_SEQUENCE "PixelMeasuresSequence"
    0x0028 0x9132 FRAME_VOILUT_SEQUENCE "FrameVOILUTSequence"
    0x0028 0x9145 PIXEL_VALUE_TRANSFORMATION_SEQUENCE "PixelValueTransformationSequence"
    0x0054 0x0022 DETECTOR_INFORMATION_SEQUENCE "DetectorInformationSequence"
    0x3004 0x000c GRID_FRAME_OFFSET_VECTOR "GridFrameOffsetVector"
    0x3004 0x000e DOSE_GRID_SCALING "DoseGridScaling"
    0x5200 0x9229 SHARED_FUNCTIONAL_GROUPS_SEQUENCE "SharedFunctionalGroupsSequence"
    0x5200 0x9230 PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE "PerFrameFunctionalGroupsSequence"
}

tags! {
    /// Elements that are told from others, or that messages name.
    OTHERS:
    0x7fe0 0x0008 FLOAT_PIXEL_DATA "FloatPixelData"
    0x7fe0 0x0009 DOUBLE_FLOAT_PIXEL_DATA "DoubleFloatPixelData"
    0x7fe0 0x0010 PIXEL_DATA "PixelData"
    0xfffe 0xe000 ITEM "Item"
    0xfffe 0xe00d ITEM_END "ItemDelimitationItem"
    0xfffe 0xe0dd SEQUENCE_END "SequenceDelimitationItem"
}

/// An element that tests pass over.
#[cfg(test)]
pub(super) const PATIENT_NAME: Tag = Tag(0x0010, 0x0010);
/// A sequence that tests pass over.
#[cfg(test)]
pub(super) const REFERENCED_IMAGE_SEQUENCE: Tag = Tag(0x0008, 0x1140);
