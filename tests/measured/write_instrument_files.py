#!/usr/bin/env python3
"""Writes the files of tests/data/synthetic: one surface in each instrument format, by the layouts alone.

    python3 tests/measured/write_instrument_files.py tests/data/synthetic

Needs nothing but Python, and h5py for the .datx and .h5 files (left out where it is missing); tests read what it wrote.
The surface is marker_map(9, 12, ...) of map_samples.h, so no flip and no transposition leaves it alone.
"""
import ctypes
import ctypes.util
import hashlib
import math
import os
import struct
import sys
import zipfile

ROWS, COLUMNS = 9, 12
PITCH_X, PITCH_Y = 0.25e-3, 0.5e-3  # [m]
WAVELENGTH = 632.8e-9  # [m]


def height(row, column):
    """[m]; row 0 is the lowest; None: no data."""
    if (row, column) in ((0, 1), (2, COLUMNS - 1)):
        return None
    bump = 50e-9 if (row, column) == (ROWS - 2, COLUMNS - 3) else 0
    return 1e-9 * (0.37 * column - 0.23 * row + math.sin(1.7 * (row + 2 * column))) + bump


UPWARDS = [height(row, column) for row in range(ROWS) for column in range(COLUMNS)]
DOWNWARDS = [height(row, column) for row in reversed(range(ROWS)) for column in range(COLUMNS)]


def write(name, data):
    with open(os.path.join(sys.argv[1], name), "wb") as file:
        file.write(data)


# ---- Wyko .opd: a directory of records of 24 bytes, then the blocks without gaps


def opd(blocks):
    count = len(blocks) + 2  # with the directory itself and a void record
    records = struct.pack("<16sHIH", b"Directory", 1, 24 * count, 0xFFFF)
    for name, kind, data in blocks:
        records += struct.pack("<16sHIH", name, kind, len(data), 8)
    records += bytes(24)
    return b"\x01\x00" + records + b"".join(data for _, _, data in blocks)


def write_opd():
    columns = [height(row, column) for column in range(COLUMNS) for row in range(ROWS)]
    size = struct.pack("<2H", COLUMNS, ROWS)
    floats = [3e38 if h is None else h / WAVELENGTH for h in columns]
    common = [(b"Wavelength", 7, struct.pack("<f", WAVELENGTH * 1e9)),
              (b"Aspect", 7, struct.pack("<f", PITCH_Y / PITCH_X)),
              (b"Pixel_size", 7, struct.pack("<f", PITCH_X * 1e3))]
    image = (b"Image", 3, size + struct.pack("<H", 1) + bytes(ROWS * COLUMNS))
    write("marker-float.opd", opd(common + [image, (b"Raw", 3, size + struct.pack("<H108f", 4, *floats)),
                                            (b"Title", 5, b"marker\0rest")]))
    mult = 20000
    counts = [32767 if h is None else round(h / WAVELENGTH * mult) for h in columns]
    other = (b"OPD", 3, size + struct.pack("<H108h", 2, *([7] * 108)))
    write("marker-counts.opd", opd([(b"PrimaryData2D", 15, b"\x12\x01\x08RAW_DATA"), other,
                                    (b"RAW_DATA", 3, size + struct.pack("<H108h", 2, *counts)),
                                    (b"Mult", 6, struct.pack("<h", mult))] + common))


# ---- .sdf: ISO 25178-71 counts profiles upwards from y = 0, BCR files begin at the top


def sdf_binary(version, counts, z_scale, kind, data):
    header = version + b"aberfit   " + b"221120261200" * 2 + struct.pack(counts, COLUMNS, ROWS)
    return header + struct.pack("<4d3B", PITCH_X, PITCH_Y, z_scale, -1, 0, kind, 0) + data


def write_sdf():
    lines = ["aISO-1.0", "ManufacID   = aberfit", "CreateDate  = 221120261200", "ModDate     = 221120261200",
             f"NumPoints   = {COLUMNS}", f"NumProfiles = {ROWS}", f"Xscale      = {PITCH_X!r}", f"Yscale      = {PITCH_Y!r}",
             "Zscale      = 1.0E-9", "Zresolution = -1", "Compression = 0", "DataType    = 7", "CheckType   = 0", "*"]
    for row in range(ROWS):
        lines.append(" ".join("BAD" if h is None else f"{h * 1e9:.9f}" for h in UPWARDS[row * COLUMNS:(row + 1) * COLUMNS]))
    write("marker-text.sdf", "\r\n".join(lines + ["*", "<PartName> 3 * 4 </PartName>", "*", ""]).encode())
    doubles = [math.nan if h is None else h * 1e6 for h in UPWARDS]
    write("marker-iso2.sdf", sdf_binary(b"bISO-2.0", "<2I", 1e-6, 7, struct.pack("<108d", *doubles)))
    step = 4e-12
    counts = [-2**15 if h is None else round(h / step) for h in UPWARDS]
    write("marker-iso1.sdf", sdf_binary(b"bISO-1.0", "<2H", step, 5, struct.pack("<108h", *counts) + b"*remarks"))
    counts = [2**15 - 1 if h is None else round(h / step) for h in DOWNWARDS]
    write("marker-bcr.sdf", sdf_binary(b"bBCR-1.0", "<2H", step, 5, struct.pack("<108h", *counts)))


# ---- .x3p: positions ascend with the index where the steps are positive


def x3p(name, packing, axes_z, data, valid=None):
    link = f"<PointDataLink>bindata/data.bin</PointDataLink><MD5ChecksumPointData>{hashlib.md5(data).hexdigest()}</MD5ChecksumPointData>"
    if valid is not None:
        link += f"<ValidPointsLink>bindata/valid.bin</ValidPointsLink><MD5ChecksumValidPoints>{hashlib.md5(valid).hexdigest()}</MD5ChecksumValidPoints>"
    axis = "<AxisType>I</AxisType><DataType>L</DataType><Increment>{}</Increment><Offset>0.125</Offset>"
    xml = f"""<?xml version="1.0" encoding="UTF-8"?>
<p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2">
  <Record1><Revision>ISO5436 - 2000</Revision><FeatureType>SUR</FeatureType>
    <Axes><CX>{axis.format(PITCH_X)}</CX><CY>{axis.format(PITCH_Y)}</CY><CZ><AxisType>A</AxisType>{axes_z}</CZ></Axes></Record1>
  <Record2><Date>2026-11-22T12:00:00</Date><Comment>marker</Comment></Record2>
  <Record3><MatrixDimension><SizeX>{COLUMNS}</SizeX><SizeY>{ROWS}</SizeY><SizeZ>1</SizeZ></MatrixDimension>
    <DataLink>{link}</DataLink></Record3>
  <Record4><ChecksumFile>md5checksum.hex</ChecksumFile></Record4>
</p:ISO5436_2>
""".encode()
    files = {"main.xml": xml, "bindata/data.bin": data}
    if valid is not None:
        files["bindata/valid.bin"] = valid
    files["md5checksum.hex"] = f"{hashlib.md5(xml).hexdigest()} *main.xml\n".encode()
    with zipfile.ZipFile(os.path.join(sys.argv[1], name), "w", packing) as archive:
        for member, content in files.items():
            archive.writestr(zipfile.ZipInfo(member), content, packing)


def write_x3p():
    doubles = struct.pack("<108d", *(math.nan if h is None else h for h in UPWARDS))
    x3p("marker-double.x3p", zipfile.ZIP_DEFLATED, "<DataType>D</DataType>", doubles)
    step, offset = 4e-12, 20e-9
    counts = struct.pack("<108h", *(-1 if h is None else round((h - offset) / step) for h in UPWARDS))
    valid = bytearray((len(UPWARDS) + 7) // 8)
    for i, h in enumerate(UPWARDS):
        valid[i // 8] |= (h is not None) << (i % 8)
    x3p("marker-counts.x3p", zipfile.ZIP_STORED,
        f"<DataType>I</DataType><Increment>{step}</Increment><Offset>{offset}</Offset>", counts, bytes(valid))


# ---- Zygo .datx: the image row at the top comes first


def write_datx():
    import h5py
    import numpy as np

    text = h5py.string_dtype()
    name = "{5b9e7b0c-3d2a-4f6e-8a41-0c5d2e7f9a10}"

    def path(file):
        return os.path.join(sys.argv[1], file)

    def converter(data, name, words, category, unit, values):
        if words is not text:
            kind = np.dtype([("Category", words), ("BaseUnit", words), ("Parameters", np.float64, (4,))])
            data.attrs[name] = np.array([(category, unit, values)], dtype=kind)
            return
        # h5py 3.7 destroys its memory when it writes a sequence beside texts: the library is called itself.
        hdf5 = ctypes.CDLL(ctypes.util.find_library("hdf5_serial") or ctypes.util.find_library("hdf5"))
        for function in ("H5Tcopy", "H5Tcreate", "H5Tvlen_create", "H5Acreate2"):
            getattr(hdf5, function).restype = ctypes.c_int64
        known = ctypes.c_int64.in_dll
        word = ctypes.c_int64(hdf5.H5Tcopy(known(hdf5, "H5T_C_S1_g")))
        hdf5.H5Tset_size(word, ctypes.c_size_t(-1))
        numbers = ctypes.c_int64(hdf5.H5Tvlen_create(known(hdf5, "H5T_IEEE_F64LE_g")))
        kind = ctypes.c_int64(hdf5.H5Tcreate(6, ctypes.c_size_t(32)))  # 6: compound
        for key, place, member in ((b"Category", 0, word), (b"BaseUnit", 8, word), (b"Parameters", 16, numbers)):
            hdf5.H5Tinsert(kind, key, ctypes.c_size_t(place), member)
        space = h5py.h5s.create_simple((1,))
        attribute = hdf5.H5Acreate2(ctypes.c_int64(data.id.id), name.encode(), kind, ctypes.c_int64(space.id),
                                    ctypes.c_int64(0), ctypes.c_int64(0))
        array = (ctypes.c_double * len(values))(*values)
        texts = [ctypes.c_char_p(t.encode()) for t in (category, unit)]
        record = struct.pack("<4Q", *(ctypes.cast(t, ctypes.c_void_p).value for t in texts), len(values),
                             ctypes.addressof(array))
        hdf5.H5Awrite(ctypes.c_int64(attribute), kind, record)
        hdf5.H5Aclose(ctypes.c_int64(attribute))

    def describe(data, unit, words, z):
        converter(data, "X Converter", words, "LateralCat", "Pixels", [0, PITCH_X, 0, 0])
        converter(data, "Y Converter", words, "LateralCat", "Pixels", [0, PITCH_Y, 0, 0])
        converter(data, "Z Converter", words, "HeightCat", unit, z)
        data.attrs["Unit"] = np.array([unit], dtype=words)

    scale, obliquity = 0.5, 1.25
    none = np.finfo(np.float64).max
    fringes = np.array([none if h is None else h / (WAVELENGTH * scale * obliquity) for h in DOWNWARDS])
    with h5py.File(path("marker-fringes.datx"), "w") as h5:
        surface = f"/Data/Surface/{name}"
        data = h5.create_dataset(surface, data=fringes.reshape(ROWS, COLUMNS), chunks=(4, 12), compression="gzip")
        describe(data, "Fringes", text, [0, WAVELENGTH, scale, obliquity])
        data.attrs["Wavelength"] = np.array([WAVELENGTH])
        data.attrs["Interferometric Scale Factor"] = np.array([scale])
        data.attrs["Obliquity Factor"] = np.array([obliquity])
        data.attrs["No Data"] = np.array([none])
        table = np.dtype([("Source", text), ("Link", text), ("Destination", text)])
        h5.create_dataset("MetaData", data=np.array([("Root", "Measurement", "{M}"), ("{M}", "Surface", "{S}"),
                                                     ("{S}", "Path", surface)], dtype=table))
        h5.create_group("Attributes").attrs["File Layout Version"] = np.array([1], dtype=np.int32)

    # As Mx writes white-light measurements; here by the newer layout of HDF5, with texts of fixed length.
    nanometres = np.array([3e38 if h is None else h * 1e9 for h in DOWNWARDS], dtype=np.float32)
    with h5py.File(path("marker-nm.datx"), "w", libver="latest") as h5:
        data = h5.create_dataset("/Measurement/Surface", data=nanometres.reshape(ROWS, COLUMNS))
        describe(data, "NanoMeters", "S12", [0, WAVELENGTH, scale, 1])
        data.attrs["No Data"] = np.float32(3e38)

    # What must not be followed: heights in another file, by a link and by storage.
    with h5py.File(path("link.datx"), "w") as h5:
        h5[f"/Data/Surface/{name}"] = h5py.ExternalLink("marker-fringes.datx", f"/Data/Surface/{name}")
    with h5py.File(path("outside.datx"), "w") as h5:
        data = h5.create_dataset(f"/Data/Surface/{name}", (ROWS, COLUMNS), dtype="f8",
                                 external=[("marker-iso2.sdf", 85, 8 * ROWS * COLUMNS)])
        describe(data, "NanoMeters", "S12", [0, WAVELENGTH, scale, 1])
        data.attrs["No Data"] = np.array([none])


# ---- 4D .h5: in waves, the top row first, 1e10 for no data


def write_4d():
    import h5py
    import numpy as np

    def waves(none):
        return np.array([none if h is None else h / WAVELENGTH for h in DOWNWARDS]).reshape(ROWS, COLUMNS)

    def path(file):
        return os.path.join(sys.argv[1], file)

    with h5py.File(path("marker-4d.h5"), "w") as h5:
        group = h5.create_group("measurement0/genraw")
        group.attrs["wavelength"] = np.bytes_("632.8 nm")
        group.attrs["xpix"] = np.bytes_("0.25 mm")
        group.create_dataset("data", data=waves(3.4e38).astype(np.float32))
    # Packed, by the newer layout of HDF5, texts of variable length, doubles, another mark of no data.
    with h5py.File(path("marker-4d-packed.h5"), "w", libver="latest") as h5:
        group = h5.create_group("measurement0/genraw")
        group.attrs["wavelength"] = "0.6328 um"
        group.create_dataset("data", data=waves(1e10), chunks=(4, 12), compression="gzip")
    # Of the later program, which says neither wavelength nor pitch here.
    with h5py.File(path("marker-4d-focus.h5"), "w") as h5:
        h5.create_dataset("/Measurement/SurfaceInWaves/Data", data=waves(np.nan))
    # HDF5 of somebody else.
    with h5py.File(path("other.h5"), "w") as h5:
        h5.create_dataset("entry/data", data=waves(0))
        h5.create_group("notes")


write_opd()
write_sdf()
write_x3p()
try:
    write_4d()
    write_datx()
except ImportError as missing:
    print(f"no .datx and .h5 files: {missing}", file=sys.stderr)
